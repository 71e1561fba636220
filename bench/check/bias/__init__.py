"""Diagnosis of an optimizer's biases, from runs of its own on functions and on noise."""

from bench.check.bias.diagnosis import diagnose

__all__ = ["diagnose"]
