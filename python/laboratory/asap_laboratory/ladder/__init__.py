"""Every consumer of the library on one stream that overloads the slow ones."""
