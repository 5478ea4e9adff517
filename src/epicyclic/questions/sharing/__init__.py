"""Load sharing by named definitions, from static or steady forces."""
