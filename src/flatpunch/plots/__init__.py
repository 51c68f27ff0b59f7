"""Pictures of results, media and indenters."""
