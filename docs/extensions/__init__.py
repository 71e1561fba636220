"""What the build makes by itself: pages from the code, figures, and results of the tutorials."""
