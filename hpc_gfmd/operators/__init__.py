"""What acts on whole fields: an elastic body, and the multilevel preconditioner."""
