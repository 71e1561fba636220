"""The conditions of a comparison: what optimizers print of themselves, and controls under matched conditions."""
