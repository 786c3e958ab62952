"""Steps of converters: how large they are, and which errors they make that no scatter shows."""
