"""Contact curves by boundary elements, with error estimates and outlines finer than the cells."""
