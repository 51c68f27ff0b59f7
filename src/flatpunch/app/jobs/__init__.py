"""The jobs of the page, one module each: what it computes, what it draws, what it saves."""
