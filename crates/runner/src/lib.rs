//! Coordinator and workers over iceoryx2 shared memory.
