"""The section “Answer”: who ends lowest, and how sure that is."""
