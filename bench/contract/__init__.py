"""The two contracts, problem and optimizer, and the objective between them."""
