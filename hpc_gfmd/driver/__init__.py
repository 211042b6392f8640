"""From a surface and a load to a certified contact: start, loop, certificate, load sweep."""
