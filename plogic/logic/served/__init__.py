"""Programs run in a child process with limits: requests, replies, and the client that asks."""
