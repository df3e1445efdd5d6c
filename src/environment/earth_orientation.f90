!> The Earth in inertial axes over an arc: by a linear angle, as CSR-TM-00-01 has it, or by the standards of the IAU.
!>
!> `report`: C = R_3(alpha_G), eq. (2-4): the Earth turns about the inertial z axis. Precession alone moves the true
!> axes away from that, 20 arcsec a year of the pole and 46 of the equinox.
!>
!> `iau`: precession IAU 2006, nutation IAU 2000B, Earth rotation angle, and UT1 and the pole where they are given:
!>
!>     C = W R_3(theta) M,  W = R_1(-y_p) R_2(-x_p),
!>     M = R_3(GST - theta) R_1(-eps_A - d_eps) R_3(-psi - d_psi) R_1(phi) R_3(gamma)
!>
!> (IERS Conventions 2010, IERS Technical Note 36, eqs. 5.1, 5.3, 5.15, 5.31, 5.40; N. Capitaine, P. T. Wallace,
!> Astron. Astrophys. 450 (2006) 855-872). Inertial axes are then those of the GCRS, which differ from the mean equator
!> and equinox of J2000 by 23 mas. M changes by 0.15 arcsec a day: it is taken at the beginning of the arc and a day
!> later, and is linear between; W is constant. What is left out: the celestial pole's offsets that are observed
!> (below 1 mas), ocean tides in UT1 and pole (below 1 mas), the locator s' (0.1 mas).
module gracecg_environment_earth_orientation
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, ARCSECOND, SECONDS_PER_DAY, DAYS_PER_CENTURY, EARTH_ROTATION_RATE
    use gracecg_base_error, only: error_t, fail_unknown_name
    use gracecg_base_vectors, only: identity, rotation_z
    use gracecg_environment_time, only: utc_t, julian_centuries_tt
    use gracecg_environment_table_nutation, only: NUTATION_TERMS, NUTATION_MULTIPLES, NUTATION_AMPLITUDES
    implicit none
    private
    public :: earth_orientation_t, earth_parameters_t, EARTH_ORIENTATIONS
    public :: new_earth_orientation, report_orientation, iau_orientation
    public :: nutation_2000b, precession_2006, earth_rotation_angle, sidereal_minus_rotation_angle

    !> The names
    character(16), parameter :: EARTH_ORIENTATIONS(2) = [character(16) :: 'report', 'iau']

    !> What is observed of the Earth's rotation. Zero where nothing is known: 0.9 s of UT1, at most, and 0.6 arcsec of
    !> the pole (420 m and 20 m on the ground) are left out then.
    type :: earth_parameters_t
        real(dp) :: ut1_minus_utc = 0       !! s
        real(dp) :: ut1_rate = 0            !! Change of it by time, s/s
        real(dp) :: pole(2) = 0             !! x_p, y_p of the pole, rad
    end type earth_parameters_t

    !> The orientation over an arc, of constants that are computed once.
    type :: earth_orientation_t
        real(dp) :: angle = 0               !! At t = 0, rad: of Greenwich, or the Earth rotation angle
        real(dp) :: rate = EARTH_ROTATION_RATE          !! Of the angle, rad/s
        logical :: turns_about_z = .true.   !! By the angle alone
        real(dp) :: equator(3, 3) = 0       !! M at t = 0, unless the Earth turns about z
        real(dp) :: equator_rate(3, 3) = 0  !! Its change, 1/s
        real(dp) :: polar_motion(3, 3) = 0  !! W
    contains
        procedure :: from_inertial          !! C: v_earth = C v_inertial
        procedure :: axis                   !! About which it turns, inertial axes
    end type earth_orientation_t

    real(dp), parameter :: MJD_J2000 = 51544.5_dp       ! 2000-01-01 12 h
    real(dp), parameter :: EXTRA_TURNS = 0.00273781191135448_dp     ! d theta/dUT1 - 1 a day, IERS Conventions eq. (5.15)
    real(dp), parameter :: TENTH_MICROARCSECOND = ARCSECOND*1e-7_dp

contains

    !> The orientation of a name from a time on. Fails when the name is not known.
    subroutine new_earth_orientation(name, epoch, sidereal_angle, parameters, orientation, error)
        character(*), intent(in) :: name                    !! One of EARTH_ORIENTATIONS
        type(utc_t), intent(in) :: epoch                    !! t = 0
        real(dp), intent(in) :: sidereal_angle              !! Of Greenwich at the epoch, rad, for 'report'
        type(earth_parameters_t), intent(in) :: parameters  !! At the epoch, for 'iau'
        type(earth_orientation_t), intent(out) :: orientation
        type(error_t), allocatable, intent(out) :: error

        select case (name)
        case ('report')
            orientation = report_orientation(sidereal_angle)
        case ('iau')
            orientation = iau_orientation(epoch, parameters)
        case default
            call fail_unknown_name(error, 'orientation of the Earth', name, EARTH_ORIENTATIONS)
        end select
    end subroutine new_earth_orientation

    !> Of CSR-TM-00-01 eq. (2-4).
    pure type(earth_orientation_t) function report_orientation(sidereal_angle) result(orientation)
        real(dp), intent(in) :: sidereal_angle              !! Of Greenwich at t = 0, rad

        orientation%angle = sidereal_angle
    end function report_orientation

    !> Of the IAU, see above.
    pure type(earth_orientation_t) function iau_orientation(epoch, parameters) result(orientation)
        type(utc_t), intent(in) :: epoch                    !! t = 0
        type(earth_parameters_t), intent(in) :: parameters  !! At the epoch

        orientation%turns_about_z = .false.
        orientation%angle = earth_rotation_angle(epoch, parameters%ut1_minus_utc)
        orientation%rate = TWO_PI*(1 + EXTRA_TURNS)/SECONDS_PER_DAY*(1 + parameters%ut1_rate)
        orientation%equator = intermediate_equator(julian_centuries_tt(epoch))
        orientation%equator_rate = (intermediate_equator(julian_centuries_tt(epoch) + 1/DAYS_PER_CENTURY) - &
                                    orientation%equator)/SECONDS_PER_DAY
        orientation%polar_motion = matmul(rotation_x(-parameters%pole(2)), rotation_y(-parameters%pole(1)))
    end function iau_orientation

    !> The rotation from inertial to Earth-fixed axes.
    pure function from_inertial(self, t) result(c)
        class(earth_orientation_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s; a day at most, where it is to hold to 1 m
        real(dp) :: c(3, 3)

        c = rotation_z(self%angle + self%rate*t)
        if (self%turns_about_z) return
        c = matmul(self%polar_motion, matmul(c, self%equator + t*self%equator_rate))
    end function from_inertial

    !> The axis about which the Earth turns, of the beginning of the arc, in inertial axes.
    pure function axis(self) result(pole)
        class(earth_orientation_t), intent(in) :: self
        real(dp) :: pole(3)                 !! Unit vector, northwards

        pole = [0.0_dp, 0.0_dp, 1.0_dp]
        if (.not. self%turns_about_z) pole = self%equator(3, :)
    end function axis

    !> Earth rotation angle: 2 pi (0.7790572732640 + 1.00273781191135448 T_u), T_u days of UT1 since J2000 (IERS
    !> Conventions 2010 eq. 5.15), 0 <= angle < 2 pi, rad.
    elemental real(dp) function earth_rotation_angle(utc, ut1_minus_utc) result(angle)
        type(utc_t), intent(in) :: utc
        real(dp), intent(in) :: ut1_minus_utc   !! s

        real(dp), parameter :: AT_J2000 = 0.7790572732640_dp    ! turns
        real(dp) :: day_fraction

        day_fraction = (utc%seconds + ut1_minus_utc)/SECONDS_PER_DAY
        angle = modulo(TWO_PI*(modulo(day_fraction, 1.0_dp) + modulo(utc%mjd - MJD_J2000, 1.0_dp) + AT_J2000 + &
                               EXTRA_TURNS*((utc%mjd - MJD_J2000) + day_fraction)), TWO_PI)
    end function earth_rotation_angle

    !> Greenwich sidereal time minus the Earth rotation angle: accumulated precession and the equation of the
    !> equinoxes, IERS Conventions 2010 eqs. 5.31 and 5.32, the two largest of its complementary terms; rad.
    elemental real(dp) function sidereal_minus_rotation_angle(t, longitude, obliquity) result(angle)
        real(dp), intent(in) :: t           !! Julian centuries of TT since J2000
        real(dp), intent(in) :: longitude   !! Nutation in longitude, rad
        real(dp), intent(in) :: obliquity   !! Mean obliquity, rad

        real(dp) :: argument(5)

        argument = delaunay_arguments(t)
        angle = (0.014506_dp + t*(4612.156534_dp + t*(1.3915817_dp + t*(-0.00000044_dp + &
                 t*(-0.000029956_dp - t*0.0000000368_dp)))))*ARCSECOND
        angle = angle + longitude*cos(obliquity) + &
                (0.00264096_dp*sin(argument(5)) + 0.00006352_dp*sin(2*argument(5)))*ARCSECOND
    end function sidereal_minus_rotation_angle

    !> Angles of the precession of IAU 2006 with the frame's bias, of Fukushima and Williams: IERS Conventions 2010
    !> eq. 5.40, rad.
    elemental subroutine precession_2006(t, gamma, phi, psi, obliquity)
        real(dp), intent(in) :: t           !! Julian centuries of TT since J2000
        real(dp), intent(out) :: gamma, phi, psi    !! The three angles of Fukushima and Williams but the last, rad
        real(dp), intent(out) :: obliquity  !! Mean, of the date, rad

        gamma = (-0.052928_dp + t*(10.556378_dp + t*(0.4932044_dp + t*(-0.00031238_dp + &
                 t*(-0.000002788_dp + t*0.0000000260_dp)))))*ARCSECOND
        phi = (84381.412819_dp + t*(-46.811016_dp + t*(0.0511268_dp + t*(0.00053289_dp + &
               t*(-0.000000440_dp - t*0.0000000176_dp)))))*ARCSECOND
        psi = (-0.041775_dp + t*(5038.481484_dp + t*(1.5584175_dp + t*(-0.00018522_dp + &
               t*(-0.000026452_dp - t*0.0000000148_dp)))))*ARCSECOND
        obliquity = (84381.406_dp + t*(-46.836769_dp + t*(-0.0001831_dp + t*(0.00200340_dp + &
                     t*(-0.000000576_dp - t*0.0000000434_dp)))))*ARCSECOND
    end subroutine precession_2006

    !> Nutation IAU 2000B: 77 terms of Moon and Sun, and constants for those of the planets (D. D. McCarthy, B. J. Luzum,
    !> Celest. Mech. Dyn. Astron. 85 (2003) 37-49); within 1 mas of IAU 2000A from 1995 to 2050.
    pure subroutine nutation_2000b(t, longitude, obliquity)
        real(dp), intent(in) :: t           !! Julian centuries of TT since J2000
        real(dp), intent(out) :: longitude  !! rad
        real(dp), intent(out) :: obliquity  !! rad

        real(dp), parameter :: PLANETS(2) = [-0.135e-3_dp, 0.388e-3_dp]     ! arcsec
        real(dp) :: arguments(5), argument
        integer :: i

        arguments = delaunay_arguments(t)
        longitude = 0
        obliquity = 0
        do i = NUTATION_TERMS, 1, -1        ! small terms first
            argument = dot_product(NUTATION_MULTIPLES(5*i - 4:5*i), arguments)
            associate (a => NUTATION_AMPLITUDES(6*i - 5:6*i))
                longitude = longitude + (a(1) + a(2)*t)*sin(argument) + a(3)*cos(argument)
                obliquity = obliquity + (a(4) + a(5)*t)*cos(argument) + a(6)*sin(argument)
            end associate
        end do
        longitude = longitude*TENTH_MICROARCSECOND + PLANETS(1)*ARCSECOND
        obliquity = obliquity*TENTH_MICROARCSECOND + PLANETS(2)*ARCSECOND
    end subroutine nutation_2000b

    !> l, l', F, D and Om of Moon and Sun to the first power of time, as IAU 2000B has them (J. L. Simon et al., Astron.
    !> Astrophys. 282 (1994) 663-683), rad.
    pure function delaunay_arguments(t) result(arguments)
        real(dp), intent(in) :: t           !! Julian centuries of TT since J2000
        real(dp) :: arguments(5)

        real(dp), parameter :: TURN = 1296000.0_dp      ! arcsec

        arguments = modulo([485868.249036_dp, 1287104.79305_dp, 335779.526232_dp, 1072260.70369_dp, 450160.398036_dp] + &
                           [1717915923.2178_dp, 129596581.0481_dp, 1739527262.8478_dp, 1602961601.2090_dp, &
                            -6962890.5431_dp]*t, TURN)*ARCSECOND
    end function delaunay_arguments

    !> M: from inertial axes to the true equator, with the origin from which the Earth rotation angle counts.
    pure function intermediate_equator(t) result(m)
        real(dp), intent(in) :: t           !! Julian centuries of TT since J2000
        real(dp) :: m(3, 3)

        real(dp) :: gamma, phi, psi, obliquity, d_longitude, d_obliquity

        call precession_2006(t, gamma, phi, psi, obliquity)
        call nutation_2000b(t, d_longitude, d_obliquity)
        m = matmul(rotation_x(phi), rotation_z(gamma))
        m = matmul(rotation_x(-obliquity - d_obliquity), matmul(rotation_z(-psi - d_longitude), m))
        m = matmul(rotation_z(sidereal_minus_rotation_angle(t, d_longitude, obliquity)), m)
    end function intermediate_equator

    !> Coordinates in a frame turned about x (passive).
    pure function rotation_x(angle) result(m)
        real(dp), intent(in) :: angle       !! rad
        real(dp) :: m(3, 3)

        m = identity(3)
        m(2:3, 2) = [cos(angle), -sin(angle)]
        m(2:3, 3) = [sin(angle), cos(angle)]
    end function rotation_x

    !> Coordinates in a frame turned about y (passive).
    pure function rotation_y(angle) result(m)
        real(dp), intent(in) :: angle       !! rad
        real(dp) :: m(3, 3)

        m = identity(3)
        m([1, 3], 1) = [cos(angle), sin(angle)]
        m([1, 3], 3) = [-sin(angle), cos(angle)]
    end function rotation_y
end module gracecg_environment_earth_orientation
