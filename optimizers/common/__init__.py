"""Base classes, compilation and bounds that several optimizers share."""
