"""What is fitted: free parameters, samples, scaling, settings."""
