"""What acts on whole fields: an elastic body, and the multilevel preconditioner with the hierarchy
it stands on."""
