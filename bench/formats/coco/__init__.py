"""COCO: its logs read and written, its archive of published results, and the best of 2009."""
