//! Graph-Laplacian and block matrices, preconditioners, filtered conjugate gradients
