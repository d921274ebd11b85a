//! What is simulated: cloth, effects, constraints, contact geometry, energies, scenes
