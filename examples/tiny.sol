Route #1: 4 6 7
Route #2: 2 5 1 3
Cost 144
