"""Find and load plug-ins: installed ones by entry point, optimizers also from a file or a function."""
