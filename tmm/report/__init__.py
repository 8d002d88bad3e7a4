"""What people ask to see of a texture database: scores, costs, pictures; and the bench of the classifiers."""
