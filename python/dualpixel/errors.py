"""What is raised for input that cannot be used."""


class InputError(ValueError):
    """A scene, lens, capture, picture or option that cannot be used.

    The text is one line that names file, field, value and what is allowed: the one that the program prints.
    """
