"""Tune optimizers on training problems, at the same budget each, and write the study that tests them on others."""
