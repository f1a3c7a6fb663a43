LSMGeometry 1.2
BoundingBox -10 -10 -10 10 10 10
PeriodicBoundaries 0 0 0
Dimension 3D
BeginParticles
Simple
2
1 2 3 0.5 0 1
4 5 6.5 1.25 1 2
EndParticles
BeginConnect
1
0 1 0
EndConnect
