"""Forces at large strain over those of linear theory, from tables of finite elements."""
