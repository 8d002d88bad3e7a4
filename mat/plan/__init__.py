"""The plan of a job: files, size and cost of its build, and the omitted parts with their bounds."""
