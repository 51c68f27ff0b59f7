"""Hard films: unloading curves, Oliver and Pharr, film modulus."""
