"""A script beside the report that makes the numbers of its tables again, without the harness."""
