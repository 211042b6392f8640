"""From a surface and a load to a judged contact: start, loop, certificate, load sweep."""
