"""What every folder may use: errors, quantities with units, atomic files, plugins."""
