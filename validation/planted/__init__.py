"""Sound methods and problems, and the same with a defect."""
