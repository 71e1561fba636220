"""Conformance of an optimizer to the contract: the table of rules, and one function a rule."""
