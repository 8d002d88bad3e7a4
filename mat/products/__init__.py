"""The products of a build, one module a file type: what each depends on and how it is computed."""
