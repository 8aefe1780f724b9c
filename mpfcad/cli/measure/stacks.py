"""`mpfcad stacks`: the backlight presets and their sources."""


def command() -> int:
    """List the backlight presets, their values and where these come from."""
    from mpfcad.backlight import list_stacks

    for stack in list_stacks():
        print(f"{stack.name}: {stack.title}")
        for entry in stack.inputs():
            print(f"  {entry['name']} = {entry['value']}  [{entry['tag']}: {entry['source']}]")
    return 0
