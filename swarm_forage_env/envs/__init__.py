"""The environment: the world and its controllers behind the interfaces of the libraries."""
