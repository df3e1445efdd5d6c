! The Fortran 77 entry points: external procedures that need no module where they are called. Their
! arguments stand in docs/api.md. Each calls the C interface, and ends with istat (0 or a status) and msg.

!> The version as a text.
subroutine gcvers(vers)
    use gracecg, only: LIBRARY_VERSION
    implicit none
    character(*), intent(inout) :: vers !! "0.1.0"

    vers = LIBRARY_VERSION
end subroutine gcvers

!> Gives an object of any kind back; its handle becomes 0.
subroutine gcfree(ih, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_f77_support, only: finish, free_any
    implicit none
    integer, intent(inout) :: ih    !! Of any kind; 0 afterwards
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    call free_any(ih, status, error)
    call finish(status, error, istat, msg)
end subroutine gcfree

!> Reads a time in ISO 8601.
subroutine gcutc(text, mjd, sec, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_general, only: c_utc_parse
    use gracecg_interface_f77_support, only: c_text, finish
    implicit none
    character(*), intent(in) :: text !! '1989-01-02T00:00:00' or '1989-01-02'
    integer, intent(inout) :: mjd    !! Modified Julian day
    real(dp), intent(inout) :: sec    !! Seconds of the day
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_utc_t) :: utc
    type(c_error_t) :: error
    integer(c_int) :: status

    utc = c_utc_t(0, 0.0_dp)
    status = c_utc_parse(c_text(text), utc, error)
    mjd = utc%mjd
    sec = utc%seconds
    call finish(status, error, istat, msg)
end subroutine gcutc

!> A time dt seconds later.
subroutine gcuadd(mjd, sec, dt, mjd2, sec2, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_general, only: c_utc_add
    use gracecg_interface_f77_support, only: finish
    implicit none
    integer, intent(in) :: mjd         !! Modified Julian day number, UTC
    real(dp), intent(in) :: sec, dt    !! s
    integer, intent(inout) :: mjd2     !! Modified Julian day number, UTC
    real(dp), intent(inout) :: sec2    !! s
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_utc_t) :: later
    type(c_error_t) :: error
    integer(c_int) :: status

    later = c_utc_t(0, 0.0_dp)
    status = c_utc_add(c_utc_t(mjd, sec), dt, later, error)
    mjd2 = later%mjd
    sec2 = later%seconds
    call finish(status, error, istat, msg)
end subroutine gcuadd

!> Seconds from time 1 to time 2.
subroutine gcudif(mjd1, sec1, mjd2, sec2, dt, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_general, only: c_utc_difference
    use gracecg_interface_f77_support, only: finish
    implicit none
    integer, intent(in) :: mjd1, mjd2     !! Modified Julian day numbers, UTC
    real(dp), intent(in) :: sec1, sec2    !! s
    real(dp), intent(inout) :: dt    !! s
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_utc_difference(c_utc_t(mjd1, sec1), c_utc_t(mjd2, sec2), dt, error)
    call finish(status, error, istat, msg)
end subroutine gcudif

!> Greenwich mean sidereal time (IAU 1982).
subroutine gcgmst(mjd, sec, dut1, theta, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_general, only: c_sidereal_angle
    use gracecg_interface_f77_support, only: finish
    implicit none
    integer, intent(in) :: mjd     !! Modified Julian day number, UTC
    real(dp), intent(in) :: sec    !! s
    real(dp), intent(in) :: dut1    !! UT1 - UTC, s
    real(dp), intent(inout) :: theta    !! rad
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_sidereal_angle(c_utc_t(mjd, sec), dut1, theta, error)
    call finish(status, error, istat, msg)
end subroutine gcgmst

!> An inertial vector in Earth-fixed axes; with -theta the way back.
subroutine gcrotz(theta, xinr, xfix, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_general, only: c_earth_fixed
    use gracecg_interface_f77_support, only: finish
    implicit none
    real(dp), intent(in) :: theta    !! Greenwich sidereal angle, rad
    real(dp), intent(in) :: xinr(3)  !! Inertial, any unit
    real(dp), intent(inout) :: xfix(3)  !! Earth-fixed, the same unit
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_earth_fixed(theta, 1_c_size_t, xinr, xfix, error)
    call finish(status, error, istat, msg)
end subroutine gcrotz

!> A gravity model: egm96, point-mass or a .gfc file.
subroutine gcgrvo(name, ndeg, nord, igrv, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_models, only: c_gravity_open
    use gracecg_interface_f77_support, only: c_text, finish_handle
    implicit none
    character(*), intent(in) :: name     !! 'egm96', 'point-mass' or a path
    integer, intent(in) :: ndeg, nord    !! Degree and order
    integer, intent(out) :: igrv         !! Handle: gravity model
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_gravity_open(c_text(name), ndeg, nord, handle, error)
    call finish_handle(status, error, handle, igrv, istat, msg)
end subroutine gcgrvo

!> Gravitational acceleration and potential.
subroutine gcgrav(igrv, xfix, a, u, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_models, only: c_gravity_evaluate
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: igrv        !! Handle: gravity model
    real(dp), intent(in) :: xfix(3)    !! Earth-fixed, m
    real(dp), intent(inout) :: a(3)    !! Earth-fixed, m/s^2
    real(dp), intent(inout) :: u    !! m^2/s^2
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    real(dp) :: value(1)
    type(c_error_t) :: error
    integer(c_int) :: status

    value = 0
    status = c_gravity_evaluate(c_handle(igrv), 1_c_size_t, xfix, a, value, error=error)
    u = value(1)
    call finish(status, error, istat, msg)
end subroutine gcgrav

!> Second derivatives of the gravitational potential.
subroutine gcgrad(igrv, xfix, g, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_models, only: c_gravity_evaluate
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: igrv        !! Handle: gravity model
    real(dp), intent(in) :: xfix(3)    !! Earth-fixed, m
    real(dp), intent(inout) :: g(3, 3)    !! 1/s^2
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_gravity_evaluate(c_handle(igrv), 1_c_size_t, xfix, gradient=g, error=error)
    call finish(status, error, istat, msg)
end subroutine gcgrad

!> A geomagnetic field at a date: igrf95, igrf14 or an SHC file.
subroutine gcfldo(name, mjd, sec, ifld, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_models, only: c_field_open
    use gracecg_interface_f77_support, only: c_text, finish_handle
    implicit none
    character(*), intent(in) :: name    !! 'igrf95', 'igrf14' or a path
    integer, intent(in) :: mjd     !! Modified Julian day number, UTC
    real(dp), intent(in) :: sec    !! s
    integer, intent(out) :: ifld   !! Handle: geomagnetic field
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_field_open(c_text(name), c_utc_t(mjd, sec), handle, error)
    call finish_handle(status, error, handle, ifld, istat, msg)
end subroutine gcfldo

!> Magnetic flux density.
subroutine gcfeld(ifld, xfix, b, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_models, only: c_field_evaluate
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: ifld        !! Handle: geomagnetic field
    real(dp), intent(in) :: xfix(3)    !! Earth-fixed, m
    real(dp), intent(inout) :: b(3)    !! Earth-fixed, T
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_field_evaluate(c_handle(ifld), 1_c_size_t, xfix, b, error)
    call finish(status, error, istat, msg)
end subroutine gcfeld

!> DTM-77 with the solar flux and Kp of a date, from the embedded table.
subroutine gcdeno(mjd, sec, iden, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_models, only: c_density_open
    use gracecg_interface_f77_support, only: finish_handle
    implicit none
    integer, intent(in) :: mjd     !! Modified Julian day number, UTC
    real(dp), intent(in) :: sec    !! s
    integer, intent(out) :: iden   !! Handle: thermosphere
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_density_open(c_utc_t(mjd, sec), handle, error)
    call finish_handle(status, error, handle, iden, istat, msg)
end subroutine gcdeno

!> DTM-77 with given indices.
subroutine gcdeni(f107, f107a, xkp, iden, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_models, only: c_density_open_indices
    use gracecg_interface_f77_support, only: finish_handle
    implicit none
    real(dp), intent(in) :: f107, f107a    !! Of the day before, 81-day mean, sfu
    real(dp), intent(in) :: xkp    !! Three hours before, 0 to 9
    integer, intent(out) :: iden           !! Handle: thermosphere
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_density_open_indices(f107, f107a, xkp, handle, error)
    call finish_handle(status, error, handle, iden, istat, msg)
end subroutine gcdeni

!> Density, temperature and composition of the thermosphere.
subroutine gcdens(iden, mjd, sec, xfix, rho, temp, xn, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_models, only: c_density_evaluate
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: iden, mjd   !! Handle: thermosphere; modified Julian day number, UTC
    real(dp), intent(in) :: sec    !! s
    real(dp), intent(in) :: xfix(3)    !! Earth-fixed, m
    real(dp), intent(inout) :: rho    !! kg/m^3
    real(dp), intent(inout) :: temp    !! K
    real(dp), intent(inout) :: xn(3)    !! He, O, N2, 1/m^3
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    real(dp) :: value(1)
    real(dp) :: kelvin(1)
    type(c_error_t) :: error
    integer(c_int) :: status

    value = 0
    kelvin = 0
    status = c_density_evaluate(c_handle(iden), c_utc_t(mjd, sec), 1_c_size_t, [0.0_dp], xfix, value, &
                                kelvin, xn, error)
    rho = value(1)
    temp = kelvin(1)
    call finish(status, error, istat, msg)
end subroutine gcdens

!> A wind: hwm93 or a file.
subroutine gcwndo(name, iwnd, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_models, only: c_wind_open
    use gracecg_interface_f77_support, only: c_text, finish_handle
    implicit none
    character(*), intent(in) :: name    !! 'hwm93' or a path
    integer, intent(out) :: iwnd        !! Handle: wind
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_wind_open(c_text(name), handle, error)
    call finish_handle(status, error, handle, iwnd, istat, msg)
end subroutine gcwndo

!> Horizontal wind relative to the turning Earth.
subroutine gcwind(iwnd, mjd, sec, xfix, weast, wnorth, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_models, only: c_wind_evaluate
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: iwnd, mjd    !! Handle: wind; modified Julian day number, UTC
    real(dp), intent(in) :: sec    !! s
    real(dp), intent(in) :: xfix(3)    !! Earth-fixed, m
    real(dp), intent(inout) :: weast, wnorth    !! m/s
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    real(dp) :: wind(2)
    type(c_error_t) :: error
    integer(c_int) :: status

    wind = 0
    status = c_wind_evaluate(c_handle(iwnd), c_utc_t(mjd, sec), 1_c_size_t, [0.0_dp], xfix, wind, error)
    weast = wind(1)
    wnorth = wind(2)
    call finish(status, error, istat, msg)
end subroutine gcwind

!> Position of the Sun.
subroutine gcsun(mjd, sec, xsun, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_models, only: c_sun_position
    use gracecg_interface_f77_support, only: finish
    implicit none
    integer, intent(in) :: mjd     !! Modified Julian day number, UTC
    real(dp), intent(in) :: sec    !! s
    real(dp), intent(inout) :: xsun(3)    !! Inertial, m
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_sun_position(c_utc_t(mjd, sec), 1_c_size_t, [0.0_dp], xsun, error)
    call finish(status, error, istat, msg)
end subroutine gcsun

!> The part of the Sun's disc that the Earth leaves free.
subroutine gcshad(x, xsun, xnu, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_models, only: c_sun_illumination
    use gracecg_interface_f77_support, only: finish
    implicit none
    real(dp), intent(in) :: x(3), xsun(3)    !! Satellite and Sun, the same axes, m
    real(dp), intent(inout) :: xnu    !! 0 to 1
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    real(dp) :: value(1)
    type(c_error_t) :: error
    integer(c_int) :: status

    value = 0
    status = c_sun_illumination(1_c_size_t, x, xsun, value, error)
    xnu = value(1)
    call finish(status, error, istat, msg)
end subroutine gcshad

!> Earth radiation with the constants report, knocke or constant-emissivity.
subroutine gcerdo(name, nrings, e0, ierd, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_models, only: c_earth_radiation_open
    use gracecg_interface_f77_support, only: c_text, finish_handle
    implicit none
    character(*), intent(in) :: name !! 'report', 'knocke' or 'constant-emissivity'
    integer, intent(in) :: nrings    !! Of segments around the cap, 0 to 7
    real(dp), intent(in) :: e0    !! Sunlight at 1 au, W/m^2
    integer, intent(out) :: ierd     !! Handle: Earth radiation
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_earth_radiation_open(c_text(name), nrings, e0, handle, error)
    call finish_handle(status, error, handle, ierd, istat, msg)
end subroutine gcerdo

!> Net flux of the Earth's light.
subroutine gcerad(ierd, mjd, sec, xinr, flux, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_models, only: c_earth_radiation_flux
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: ierd, mjd    !! Handle: Earth radiation; modified Julian day number, UTC
    real(dp), intent(in) :: sec    !! s
    real(dp), intent(in) :: xinr(3)    !! Inertial, m
    real(dp), intent(inout) :: flux(3)    !! Inertial, W/m^2
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_earth_radiation_flux(c_handle(ierd), c_utc_t(mjd, sec), 1_c_size_t, [0.0_dp], xinr, flux, error)
    call finish(status, error, istat, msg)
end subroutine gcerad

!> The surface of a trapezoidal prism, as GRACE is.
subroutine gctrap(xlen, high, wbot, wtop, spec, diff, isur, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_surface, only: c_surface_trapezoid
    use gracecg_interface_f77_support, only: finish_handle
    implicit none
    real(dp), intent(in) :: xlen, high    !! m
    real(dp), intent(in) :: wbot, wtop    !! m
    real(dp), intent(in) :: spec, diff    !! Reflected parts of the light
    integer, intent(out) :: isur          !! Handle: surface
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_surface_trapezoid(xlen, high, wbot, wtop, spec, diff, handle, error)
    call finish_handle(status, error, handle, isur, istat, msg)
end subroutine gctrap

!> The surface of a closed convex body of plates.
subroutine gcplat(n, xnrm, area, cen, spec, diff, isur, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_surface, only: c_surface_create
    use gracecg_interface_f77_support, only: finish_handle
    implicit none
    integer, intent(in) :: n    !! 1 to 32
    real(dp), intent(in) :: xnrm(3, *)    !! Unit normals outwards, body axes
    real(dp), intent(in) :: area(*)    !! m^2
    real(dp), intent(in) :: cen(3, *)    !! Centres, m
    real(dp), intent(in) :: spec(*), diff(*)    !! Reflected parts of the light
    integer, intent(out) :: isur    !! Handle: surface
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_surface_create(int(n, c_size_t), xnrm, area, cen, spec, diff, handle, error)
    call finish_handle(status, error, handle, isur, istat, msg)
end subroutine gcplat

!> Drag with one coefficient.
subroutine gcdrag(isur, xmass, cd, rho, v, a, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_surface, only: c_surface_drag
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: isur      !! Handle: surface
    real(dp), intent(in) :: xmass    !! kg
    real(dp), intent(in) :: cd    !! Drag coefficient
    real(dp), intent(in) :: rho    !! kg/m^3
    real(dp), intent(in) :: v(3)    !! Relative to the air, body axes, m/s
    real(dp), intent(inout) :: a(3)    !! Body axes, m/s^2
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_surface_drag(c_handle(isur), xmass, cd, rho, v, a, error)
    call finish(status, error, istat, msg)
end subroutine gcdrag

!> Pressure of sunlight with one reflectivity.
subroutine gcsrp(isur, xmass, eta, e0, xnu, tosun, a, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_surface, only: c_surface_sunlight
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: isur    !! Handle: surface
    real(dp), intent(in) :: xmass    !! kg
    real(dp), intent(in) :: eta    !! Reflectivity
    real(dp), intent(in) :: e0    !! Sunlight at 1 au, W/m^2
    real(dp), intent(in) :: xnu    !! Free part of the Sun's disc, 0 to 1
    real(dp), intent(in) :: tosun(3)    !! From satellite to Sun, body axes, m
    real(dp), intent(inout) :: a(3)    !! Body axes, m/s^2
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_surface_sunlight(c_handle(isur), xmass, eta, e0, xnu, tosun, a, error)
    call finish(status, error, istat, msg)
end subroutine gcsrp

!> Pressure of the Earth's light with one reflectivity.
subroutine gcerp(isur, xmass, eta, flux, xinr, q, a, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_surface, only: c_surface_earthlight
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: isur        !! Handle: surface
    real(dp), intent(in) :: xmass    !! kg
    real(dp), intent(in) :: eta    !! Reflectivity
    real(dp), intent(in) :: flux(3)    !! Of GCERAD, inertial, W/m^2
    real(dp), intent(in) :: xinr(3)    !! Inertial, m
    real(dp), intent(in) :: q(4)    !! Inertial to body, scalar last
    real(dp), intent(inout) :: a(3)    !! Body axes, m/s^2
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_surface_earthlight(c_handle(isur), xmass, eta, flux, xinr, q, a, error)
    call finish(status, error, istat, msg)
end subroutine gcerp

!> A built-in case, or one from a case file.
subroutine gccase(name, icas, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_dynamics, only: c_case_open
    use gracecg_interface_f77_support, only: c_text, finish_handle
    implicit none
    character(*), intent(in) :: name    !! 'front-1' ... 'back-3', or a path
    integer, intent(out) :: icas        !! Handle: case
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_case_open(c_text(name), handle, error)
    call finish_handle(status, error, handle, icas, istat, msg)
end subroutine gccase

!> What a case begins with.
subroutine gccini(icas, mjd, sec, dur, dt, x, d, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, c_utc_t
    use gracecg_interface_c_dynamics, only: c_case_values
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: icas       !! Handle: case
    integer, intent(inout) :: mjd     !! Modified Julian day number, UTC
    real(dp), intent(inout) :: sec    !! Epoch, s of the day
    real(dp), intent(inout) :: dur, dt    !! Duration and interval of the arc, s
    real(dp), intent(inout) :: x(13)    !! State: m, m/s, rad/s, quaternion
    real(dp), intent(inout) :: d(3)    !! True offset, body axes, m
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_utc_t) :: utc
    type(c_error_t) :: error
    integer(c_int) :: status

    utc = c_utc_t(0, 0.0_dp)
    status = c_case_values(c_handle(icas), utc, dur, dt, x, d, error)
    mjd = utc%mjd
    sec = utc%seconds
    call finish(status, error, istat, msg)
end subroutine gccini

!> The force model of a case.
subroutine gcfrco(icas, ifrc, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_dynamics, only: c_force_model_open
    use gracecg_interface_f77_support, only: c_handle, finish_handle
    implicit none
    integer, intent(in) :: icas     !! Handle: case
    integer, intent(out) :: ifrc    !! Handle: force model
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_force_model_open(c_handle(icas), handle, error)
    call finish_handle(status, error, handle, ifrc, istat, msg)
end subroutine gcfrco

!> Accelerations of the satellite: gravity, drag, sunlight, the Earth's light, and their sum.
subroutine gcforc(ifrc, t, x, v, q, agrv, adrg, asun, aerd, atot, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_dynamics, only: c_force_model_evaluate
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: ifrc  !! Handle: force model
    real(dp), intent(in) :: t    !! From the case's epoch, s
    real(dp), intent(in) :: x(3), v(3)    !! Inertial, m and m/s
    real(dp), intent(in) :: q(4)    !! Inertial to body, scalar last
    real(dp), intent(inout) :: agrv(3), adrg(3), asun(3), aerd(3), atot(3)    !! Inertial, m/s^2
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_force_model_evaluate(c_handle(ifrc), 1_c_size_t, [t], x, v, q, agrv, adrg, asun, aerd, &
                                    atot, error)
    call finish(status, error, istat, msg)
end subroutine gcforc

!> Torques of air, sunlight, gravity gradient and rods, and the magnetic field.
subroutine gcload(ifrc, t, x, torq, b, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_dynamics, only: c_force_model_torques
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: ifrc  !! Handle: force model
    real(dp), intent(in) :: t    !! From the case's epoch, s
    real(dp), intent(in) :: x(13)    !! State
    real(dp), intent(inout) :: torq(3, 4)    !! Body axes, N m
    real(dp), intent(inout) :: b(3)    !! Body axes, T
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_force_model_torques(c_handle(ifrc), t, x, torq(:, 1), torq(:, 2), torq(:, 3), torq(:, 4), b, &
                                   error)
    call finish(status, error, istat, msg)
end subroutine gcload

!> Time derivative of the state.
subroutine gcrate(ifrc, t, x, xdot, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_dynamics, only: c_force_model_rate
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: ifrc  !! Handle: force model
    real(dp), intent(in) :: t    !! From the case's epoch, s
    real(dp), intent(in) :: x(13)    !! State
    real(dp), intent(inout) :: xdot(13) !! Per s
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_force_model_rate(c_handle(ifrc), t, x, xdot, error)
    call finish(status, error, istat, msg)
end subroutine gcrate

!> Propagates orbit and attitude from the case's epoch, one Runge-Kutta 7(8) step an interval.
subroutine gcprop(ifrc, x, dt, n, xout, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_dynamics, only: c_force_model_propagate
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: ifrc      !! Handle: force model
    real(dp), intent(in) :: x(13)    !! State at time 0
    real(dp), intent(in) :: dt    !! Interval, s
    integer, intent(in) :: n    !! Steps
    real(dp), intent(inout) :: xout(13, *)    !! n + 1 states, the first one x
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_force_model_propagate(c_handle(ifrc), x, dt, int(n, c_size_t), 0.0_dp, xout, error)
    call finish(status, error, istat, msg)
end subroutine gcprop

!> The simulator of a case: propagates its truth.
subroutine gcsimo(icas, isim, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_estimation, only: c_simulator_open
    use gracecg_interface_f77_support, only: c_handle, finish_handle
    implicit none
    integer, intent(in) :: icas     !! Handle: case
    integer, intent(out) :: isim    !! Handle: simulator
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_simulator_open(c_handle(icas), handle, error)
    call finish_handle(status, error, handle, isim, istat, msg)
end subroutine gcsimo

!> One noisy observation set.
subroutine gcsimu(isim, iseed, irun, iobs, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_estimation, only: c_observations_simulate
    use gracecg_interface_f77_support, only: c_handle, finish_handle
    implicit none
    integer, intent(in) :: isim           !! Handle: simulator
    integer, intent(in) :: iseed, irun    !! Alone decide the random numbers
    integer, intent(out) :: iobs          !! Handle: observation set
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_observations_simulate(c_handle(isim), iseed, irun, handle, error)
    call finish_handle(status, error, handle, iobs, istat, msg)
end subroutine gcsimu

!> Reads a setup.nml.
subroutine gcsetr(file, iset, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_estimation, only: c_setup_read
    use gracecg_interface_f77_support, only: c_text, finish_handle
    implicit none
    character(*), intent(in) :: file    !! Path of a setup.nml
    integer, intent(out) :: iset        !! Handle: setup
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_setup_read(c_text(file), handle, error)
    call finish_handle(status, error, handle, iset, istat, msg)
end subroutine gcsetr

!> Reads an observation set from its folder.
subroutine gcobsr(dir, iobs, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_estimation, only: c_observations_read
    use gracecg_interface_f77_support, only: c_text, finish_handle
    implicit none
    character(*), intent(in) :: dir !! Folder
    integer, intent(out) :: iobs    !! Handle: observation set
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_observations_read(c_text(dir), handle, error)
    call finish_handle(status, error, handle, iobs, istat, msg)
end subroutine gcobsr

!> Writes an observation set into a folder.
subroutine gcobsw(iobs, dir, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_estimation, only: c_observations_write
    use gracecg_interface_f77_support, only: c_text, c_handle, finish
    implicit none
    integer, intent(in) :: iobs     !! Handle: observation set
    character(*), intent(in) :: dir !! Folder; made if it is not there
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_observations_write(c_handle(iobs), c_text(dir), error)
    call finish(status, error, istat, msg)
end subroutine gcobsw

!> Samples of accelerometer, star camera, magnetometer, orbit.
subroutine gcobsn(iobs, n, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_interface_c_support, only: c_error_t
    use gracecg_interface_c_estimation, only: c_observations_counts
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: iobs     !! Handle: observation set
    integer, intent(inout) :: n(4)  !! Numbers of samples
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_size_t) :: counts(4)
    type(c_error_t) :: error
    integer(c_int) :: status

    counts = 0
    status = c_observations_counts(c_handle(iobs), counts, error)
    n = int(counts)
    call finish(status, error, istat, msg)
end subroutine gcobsn

!> An observation set from arrays; times in seconds from the setup's epoch.
subroutine gcobsc(iset, na, ta, a, ns, ts, ihead, q, nm, tm, b, no, to, xo, iobs, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_SIZE, start, raise
    use gracecg_interface_c_estimation, only: create_observations
    use gracecg_interface_f77_support, only: c_handle, finish_handle
    implicit none
    integer, intent(in) :: iset                     !! Handle: setup
    integer, intent(in) :: na                       !! Samples of the accelerometer
    real(dp), intent(in) :: ta(*), a(3, *)          !! s; body axes, m/s^2
    integer, intent(in) :: ns                       !! Of the star camera
    real(dp), intent(in) :: ts(*), q(4, *)          !! s; inertial to camera, scalar last
    integer, intent(in) :: ihead(*)                 !! 1 or 2
    integer, intent(in) :: nm                       !! Of the magnetometer
    real(dp), intent(in) :: tm(*), b(3, *)          !! s; body axes, T
    integer, intent(in) :: no                       !! Positions
    real(dp), intent(in) :: to(*), xo(3, *)         !! s; inertial, m
    integer, intent(out) :: iobs                    !! Handle: observation set
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    call start(status, error)
    handle = 0
    if (min(na, ns, nm, no) < 0) then
        call raise(STATUS_BAD_SIZE, 'a number of samples is negative', status, error)
    else
        call create_observations(c_handle(iset), ta(:na), a(:, :na), ts(:ns), ihead(:ns), q(:, :ns), &
                                 tm(:nm), b(:, :nm), to(:no), xo(:, :no), handle, status, error)
    end if
    call finish_handle(status, error, handle, iobs, istat, msg)
end subroutine gcobsc

!> Estimates the offset from observations. On success msg holds the warnings, if any.
subroutine gcestm(algo, iobs, d, cov, rms, cond, niter, iconv, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_NOT_CONVERGED, MESSAGE_SIZE
    use gracecg_interface_c_estimation, only: c_solution_t, c_estimate
    use gracecg_interface_f77_support, only: c_text, c_handle, finish
    implicit none
    character(*), intent(in) :: algo                !! Name of the algorithm
    integer, intent(in) :: iobs                     !! Handle: observation set
    real(dp), intent(inout) :: d(3)                 !! Offset, body axes, m
    real(dp), intent(inout) :: cov(3, 3)            !! Its covariance, m^2
    real(dp), intent(inout) :: rms(3)               !! Of the accelerometer's residuals, m/s^2
    real(dp), intent(inout) :: cond                 !! Condition number of the normal matrix
    integer, intent(inout) :: niter                 !! Iterations
    integer, intent(inout) :: iconv                 !! 1: converged, 0: not
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    character(kind=c_char) :: warnings(MESSAGE_SIZE)
    type(c_solution_t) :: solution
    type(c_error_t) :: error
    integer(c_int) :: status

    warnings(1) = c_null_char
    status = c_estimate(c_text(algo), c_handle(iobs), solution, warnings, size(warnings, kind=c_size_t), error)
    if (status == STATUS_OK .or. status == STATUS_NOT_CONVERGED) then
        d = solution%offset
        cov = solution%covariance
        rms = solution%residual_rms
        cond = solution%condition
        niter = solution%iterations
        iconv = solution%converged
    end if
    if (status == STATUS_OK) error%message = warnings
    call finish(status, error, istat, msg)
end subroutine gcestm

!> The least covariance of the offset with the manoeuvre and the noise of a case.
subroutine gcbnd(icas, sig, cov, psig, dir, csig, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK
    use gracecg_interface_c_planning, only: c_bound_t, c_case_bound
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: icas                     !! Handle: case
    real(dp), intent(inout) :: sig(3)               !! Standard deviations, body axes, m
    real(dp), intent(inout) :: cov(3, 3)            !! Covariance, m^2
    real(dp), intent(inout) :: psig(3)              !! Of the error ellipsoid, ascending, m
    real(dp), intent(inout) :: dir(3, 3)            !! Its directions as columns; the last is the worst
    real(dp), intent(inout) :: csig(3)              !! With what is known only within limits, m
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_bound_t) :: bound
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_case_bound(c_handle(icas), bound, error)
    if (status == STATUS_OK) then
        sig = bound%sigma
        cov = bound%covariance
        psig = bound%principal_sigma
        dir = bound%direction
        csig = bound%consider_sigma
    end if
    call finish(status, error, istat, msg)
end subroutine gcbnd

!> The settings of the planner that `gracecg design` has for a case, to be changed and given to gcdsgn.
subroutine gcdsgd(icas, opt, iopt, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK
    use gracecg_interface_c_planning, only: c_design_settings_t, c_design_defaults
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: icas                     !! Handle: case
    real(dp), intent(inout) :: opt(9)
    !! Start, duration (s), amplitude (A m^2), lowest and highest frequency (Hz), taper, rise time (s), limits
    !! of rate (rad/s) and pointing (rad)
    integer, intent(inout) :: iopt(8)               !! Rods x, y, z; four waveforms: 1 or 0; threads
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_design_settings_t) :: settings
    type(c_error_t) :: error
    integer(c_int) :: status

    status = c_design_defaults(c_handle(icas), settings, error)
    if (status == STATUS_OK) then
        opt = [settings%start, settings%duration, settings%amplitude, settings%lowest_frequency, &
               settings%highest_frequency, settings%taper, settings%rise_time, settings%rate_limit, &
               settings%pointing_limit]
        iopt = [settings%rod_used, settings%waveform_used, settings%threads]
    end if
    call finish(status, error, istat, msg)
end subroutine gcdsgd

!> Searches the manoeuvre with the best worst axis.
subroutine gcdsgn(icas, opt, iopt, jcas, sig, wave, frc, amot, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK
    use gracecg_interface_c_planning, only: c_design_settings_t, c_design_t, c_design_manoeuvre
    use gracecg_interface_f77_support, only: c_handle, finish_handle
    implicit none
    integer, intent(in) :: icas                     !! Handle: case
    real(dp), intent(in) :: opt(9)                  !! As gcdsgd gives it
    integer, intent(in) :: iopt(8)                  !! As gcdsgd gives it
    integer, intent(out) :: jcas                    !! Handle: case with the manoeuvre
    real(dp), intent(inout) :: sig(3)               !! Limit under the accelerometer's noise, m
    real(dp), intent(inout) :: wave(3)              !! Error by the density wave, m
    real(dp), intent(inout) :: frc(3)               !! Error by curved drag and radiation, m
    real(dp), intent(inout) :: amot(2)              !! Greatest angular velocity, rad/s, and turn, rad
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_design_settings_t) :: settings
    type(c_design_t) :: design
    type(c_error_t) :: error
    integer(c_int) :: status

    settings = c_design_settings_t(opt(1), opt(2), opt(3), opt(4), opt(5), opt(6), opt(7), opt(8), opt(9), &
                                   iopt(1:3), iopt(4:7), iopt(8))
    status = c_design_manoeuvre(c_handle(icas), settings, handle, design, error)
    if (status == STATUS_OK) then
        sig = design%sigma
        wave = design%wave
        frc = design%force
        amot = [design%rate, design%excursion]
    end if
    call finish_handle(status, error, handle, jcas, istat, msg)
end subroutine gcdsgn

!> The torque rods of a case.
subroutine gcrods(icas, nmax, n, rod, irod, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_SIZE, start, raise
    use gracecg_interface_c_planning, only: c_rod_t, c_case_rods
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: icas                     !! Handle: case
    integer, intent(in) :: nmax                     !! Columns of the arrays
    integer, intent(out) :: n                       !! Activations
    real(dp), intent(inout) :: rod(7, *)
    !! Amplitude (A m^2), frequency (Hz), phase (rad), start, stop, taper, rise time (s)
    integer, intent(inout) :: irod(2, *)            !! Axis, waveform
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    type(c_rod_t), allocatable :: rods(:)
    type(c_error_t) :: error
    integer(c_size_t) :: count
    integer(c_int) :: status
    integer :: i

    count = 0
    call start(status, error)
    if (nmax < 0) then
        call raise(STATUS_BAD_SIZE, 'a number of columns is negative', status, error)
    else
        status = c_case_rods(c_handle(icas), 0_c_size_t, count, error=error)
    end if
    if (status == STATUS_OK) then
        allocate (rods(count))
        status = c_case_rods(c_handle(icas), int(min(int(count), nmax), c_size_t), count, rods, error)
    end if
    if (status == STATUS_OK) then
        do i = 1, int(count)
            rod(:, i) = [rods(i)%amplitude, rods(i)%frequency, rods(i)%phase, rods(i)%start, rods(i)%stop, &
                         rods(i)%taper, rods(i)%rise_time]
            irod(:, i) = [rods(i)%axis, rods(i)%waveform]
        end do
    end if
    n = int(count)
    call finish(status, error, istat, msg)
end subroutine gcrods

!> The manoeuvre of a case at places of its orbit.
subroutine gcmap(icas, nplc, t, nthr, plc, sig, wrst, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_SIZE, start, raise
    use gracecg_interface_c_planning, only: c_map
    use gracecg_interface_f77_support, only: c_handle, finish
    implicit none
    integer, intent(in) :: icas                     !! Handle: case
    integer, intent(in) :: nplc                     !! Places
    real(dp), intent(in) :: t(*)                    !! Starts of the calibration, s from the case's epoch
    integer, intent(in) :: nthr                     !! Threads
    real(dp), intent(inout) :: plc(2, *)            !! Geodetic latitude and longitude, rad
    real(dp), intent(inout) :: sig(3, *)            !! Standard deviations, m
    real(dp), intent(inout) :: wrst(4, *)           !! Worst direction: standard deviation (m), unit vector
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    real(dp), allocatable :: latitude(:), longitude(:), worst(:), direction(:, :)
    type(c_error_t) :: error
    integer(c_int) :: status

    call start(status, error)
    if (nplc < 0) then
        call raise(STATUS_BAD_SIZE, 'the number of places is negative', status, error)
    else
        allocate (latitude(nplc), longitude(nplc), worst(nplc), direction(3, nplc))
        status = c_map(c_handle(icas), int(nplc, c_size_t), t(:nplc), nthr, latitude, longitude, sig, worst, &
                       direction, error=error)
        if (status == STATUS_OK) then
            plc(1, :nplc) = latitude
            plc(2, :nplc) = longitude
            wrst(1, :nplc) = worst
            wrst(2:4, :nplc) = direction
        end if
    end if
    call finish(status, error, istat, msg)
end subroutine gcmap
