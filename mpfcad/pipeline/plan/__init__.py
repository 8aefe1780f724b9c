"""What a job asks for, read and refused before anything is written."""
