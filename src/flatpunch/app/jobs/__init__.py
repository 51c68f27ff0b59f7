"""What the worker processes of the page call: a module for each tab, and one for two that are alike.

A job takes the fields of the form and whether it may take longer than about a second (`run`); it returns plain data: "problems"
with the form, or what the page shows, with "kept", the result itself as bytes. Details take the form, these bytes and a step;
files take the form, these bytes and a kind, "nc", "csv", "png" or "svg", and are those that the command line writes.
"""
