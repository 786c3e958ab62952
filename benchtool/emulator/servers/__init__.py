"""The wires of the emulated drive: each server carries one firmware over one kind of link."""
