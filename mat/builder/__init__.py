"""Building the files of a plan: tasks, executors, kept files, the record of cost."""
