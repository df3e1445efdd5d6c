!> Physical and mathematical constants and units: each once, with its unit and source.
!>
!> Constants that belong to one model alone (a reference radius of a coefficient set, say) stand in
!> that model's module or table.
module gracecg_base_constants
    use gracecg_base_kinds, only: dp
    implicit none
    private

    !> Circumference over diameter of a circle
    real(dp), parameter, public :: PI = 3.14159265358979323846_dp
    !> Radians in a full turn
    real(dp), parameter, public :: TWO_PI = 2*PI
    real(dp), parameter, public :: DEGREE = PI/180          !! rad
    real(dp), parameter, public :: ARCSECOND = DEGREE/3600  !! rad
    real(dp), parameter, public :: MILLIMETRE = 1e-3_dp     !! m; a length in mm is length/MILLIMETRE
    real(dp), parameter, public :: MICROMETRE = 1e-6_dp     !! m
    real(dp), parameter, public :: KILOMETRE = 1e3_dp       !! m
    real(dp), parameter, public :: NANOTESLA = 1e-9_dp      !! T
    real(dp), parameter, public :: MICROTESLA = 1e-6_dp     !! T
    real(dp), parameter, public :: HOUR_ANGLE = PI/12       !! rad for one hour of right ascension

    !> Names of the axes of a frame
    character(1), parameter, public :: AXES(3) = ['x', 'y', 'z']

    !> s
    real(dp), parameter, public :: SECONDS_PER_DAY = 86400.0_dp
    real(dp), parameter, public :: JULIAN_YEAR = 365.25_dp*SECONDS_PER_DAY      !! s
    !> In a Julian century, of time scales counted from J2000
    real(dp), parameter, public :: DAYS_PER_CENTURY = 36525.0_dp
    !> From a modified Julian day to a Julian date, days
    real(dp), parameter, public :: MJD_TO_JD = 2400000.5_dp

    real(dp), parameter, public :: EARTH_GM = 398600.4415e9_dp
    !! Geocentric gravitational constant, m^3/s^2: CSR-TM-00-01 section 5.2, and EGM96
    real(dp), parameter, public :: EARTH_RADIUS_EGM96 = 6378136.3_dp
    !! Reference radius of EGM96, m
    real(dp), parameter, public :: EARTH_RADIUS_IGRF = 6371200.0_dp
    !! Mean reference radius of the IGRF, m (CSR-TM-00-01 eq. 2-26)
    real(dp), parameter, public :: WGS84_SEMI_MAJOR_AXIS = 6378137.0_dp
    !! m
    !> f = (a - b)/a, exact by definition
    real(dp), parameter, public :: WGS84_FLATTENING = 1/298.257223563_dp
    real(dp), parameter, public :: EARTH_ROTATION_RATE = 7.292115e-5_dp
    !! Angular velocity of the Earth, rad/s: IERS Conventions (2010), nominal value

    real(dp), parameter, public :: SPEED_OF_LIGHT = 299792458.0_dp
    !! m/s, exact
    real(dp), parameter, public :: ASTRONOMICAL_UNIT = 149597870700.0_dp
    !! m, exact (IAU 2012 resolution B2)
    real(dp), parameter, public :: SOLAR_RADIUS = 695700.0e3_dp
    !! m, nominal (IAU 2015 resolution B3)
end module gracecg_base_constants
