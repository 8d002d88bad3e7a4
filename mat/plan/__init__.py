"""What a job will build, what it leaves out and why, and what that costs."""
