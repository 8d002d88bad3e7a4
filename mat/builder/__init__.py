"""From a plan to files: tasks, executors, what is kept, the record of cost."""
