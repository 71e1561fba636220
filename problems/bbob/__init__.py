"""COCO's single-objective suites: bbob and its boxed, large-scale, noisy, constrained and mixed-integer relatives."""
