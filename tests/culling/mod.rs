//! What cameras and lights see: exactly what Bevy's own systems say.

mod differential;
