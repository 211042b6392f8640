"""What acts on whole fields: the elastic half-space, and the multilevel preconditioner with the hierarchy it stands on."""
