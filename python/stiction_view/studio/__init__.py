"""`stiction studio`: pose a task, plan it, look at what came out, in the browser."""
