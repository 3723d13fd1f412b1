"""Frames as they come, from a video, a stream of pictures or a camera, and what each shows."""
