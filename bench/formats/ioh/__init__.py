"""IOHprofiler: its logs read and written, and those of its versions before JSON read."""
