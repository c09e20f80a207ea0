// How many invocations a workgroup has. Grids are written by these (see invocation_index).

/// Where nothing else is said.
const WORKGROUP: u32 = 64u;

/// In kernels that load and evaluate materials. These wait for memory: neighbours on one processor find in
/// its cache what the others have read, and a wide workgroup leaves each of them fewer registers, so that
/// more of them wait at once. A GPU says what suits it; a power of two up to GRID_ROW.
override SHADE_WORKGROUP: u32 = 64u;
