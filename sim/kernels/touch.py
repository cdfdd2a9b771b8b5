"""Everything that touches: rods with rods and with tines."""

from sim.kernels.compiled import kernel
from sim.kernels.contact import contact_forces
from sim.kernels.tine import place, tine_forces


@kernel
def touching_loads(buf, n, time, dt, contact, friction, tines, tine_friction):
    """Add the forces and couples of everything that touches."""
    if contact is not None:
        contact_forces(buf, n, dt, contact, friction)
    if tines is not None:
        place(tines, time)
        tine_forces(buf, n, dt, tines, tine_friction)
