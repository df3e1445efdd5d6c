!> The main magnetic field of the Earth: the International Geomagnetic Reference Field (IGRF), or
!> other coefficients of the same kind.
!>
!> Positions and results are in the Earth-fixed frame (z along the axis of rotation, x in the
!> meridian of Greenwich).
module gracecg_environment_geomagnetic_field
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_RADIUS_IGRF, EARTH_RADIUS_EGM96, NANOTESLA
    use gracecg_base_error, only: error_t, add_context, fail, fail_out_of_range, fail_unknown_name
    use gracecg_environment_spherical_harmonics, only: MAX_DEGREE, harmonic_function_t, &
        new_harmonic_function
    use gracecg_environment_table_igrf, only: IGRF14_DEGREE, IGRF14_EPOCHS, IGRF14_FIELDS, IGRF14_RATE, &
        IGRF95_DEGREE, IGRF95_FIELD, IGRF95_RATE
    implicit none
    private
    public :: geomagnetic_model_t, igrf_t, igrf, new_igrf, coefficients_at, spherical_components, is_extrapolated

    type, abstract :: geomagnetic_model_t
        !! Any model of the field; evaluation is undefined at the centre
    contains
        procedure(evaluate_interface), deferred :: evaluate !! Magnetic flux density at a place
    end type geomagnetic_model_t

    abstract interface
        !> The magnetic flux density.
        pure subroutine evaluate_interface(self, position, b)
            import :: geomagnetic_model_t, dp
            class(geomagnetic_model_t), intent(in) :: self
            real(dp), intent(in) :: position(3)     !! Earth-fixed, m
            real(dp), intent(out) :: b(3)           !! Earth-fixed, T
        end subroutine evaluate_interface
    end interface

    type, extends(geomagnetic_model_t) :: igrf_t
        !! Spherical harmonics of internal sources at one date, CSR-TM-00-01 eq. (2-26); made by
        !! igrf, read_shc or new_igrf
        character(:), allocatable :: name               !! 'igrf14', or as its file says
        integer :: degree = 0                           !! Highest of the expansion
        type(harmonic_function_t) :: potential              !! -V, T m
    contains
        procedure :: evaluate => igrf_evaluate
    end type igrf_t

    character(6), parameter :: GENERATIONS(*) = ['igrf95', 'igrf14']
    real(dp), parameter :: RATE_SPAN = 5        !! Years for which a secular variation is given
    real(dp), parameter :: IGRF14_END = 2030, IGRF14_LAST = 2040    !! Where that of the 14th ends; to which it is extrapolated

contains

    !> The IGRF at a date: 'igrf95' is the 7th generation as issued in 1995 (DGRF 1985 and 1990,
    !> IGRF 1995 with its secular variation; 1985.0 to 2000.0), 'igrf14' the 14th (1900.0 to
    !> 2030.0, and by its last secular variation to 2040.0). Linear between the epochs. Fails on an unknown generation and on
    !> a date outside its range.
    subroutine igrf(generation, decimal_year, model, error)
        character(*), intent(in) :: generation  !! 'igrf95' or 'igrf14'
        real(dp), intent(in) :: decimal_year    !! Year with decimals: 1989.0 is 1 January 0 h
        type(igrf_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: epochs(:), tables(:, :), list(:)
        integer :: degree

        select case (generation)
        case ('igrf95')
            degree = IGRF95_DEGREE
            call generation_7(epochs, tables)
        case ('igrf14')
            degree = IGRF14_DEGREE
            call generation_14(epochs, tables)
        case default
            call fail_unknown_name(error, 'generation of the geomagnetic reference field', generation, GENERATIONS)
            return
        end select
        call coefficients_at(decimal_year, epochs, tables, list, error)
        call add_context(error, generation)
        if (allocated(error)) then
            if (generation == 'igrf95') error%message = error%message//'; igrf14 covers 1900 to 2030 (to 2040 by extrapolation)'
            return
        end if
        call new_igrf(generation, EARTH_RADIUS_IGRF, degree, list, model, error)
    end subroutine igrf

    !> Is the field of a generation extrapolated at a date? The secular variation changes by some nT/yr each year.
    pure logical function is_extrapolated(generation, decimal_year)
        character(*), intent(in) :: generation  !! 'igrf95' or 'igrf14'
        real(dp), intent(in) :: decimal_year    !! Year with decimals

        is_extrapolated = generation == 'igrf14' .and. decimal_year > IGRF14_END
    end function is_extrapolated

    !> The lists of coefficients of the 7th generation at its epochs and at the end of its validity.
    pure subroutine generation_7(epochs, tables)
        real(dp), allocatable, intent(out) :: epochs(:)     !! Decimal years
        real(dp), allocatable, intent(out) :: tables(:, :)  !! nT; one column an epoch

        integer, parameter :: COUNT_95 = size(IGRF95_FIELD), COUNT_14 = size(IGRF14_RATE)
        integer :: i, first

        epochs = [1985.0_dp, 1990.0_dp, 1995.0_dp, 1995.0_dp + RATE_SPAN]
        allocate (tables(COUNT_95, 4))
        do i = 1, 2     ! definitive models: the same in all later generations
            first = (findloc(IGRF14_EPOCHS, epochs(i), 1) - 1)*COUNT_14 + 1
            tables(:, i) = IGRF14_FIELDS(first:first + COUNT_95 - 1)
        end do
        tables(:, 3) = IGRF95_FIELD
        tables(:, 4) = IGRF95_FIELD + RATE_SPAN*IGRF95_RATE
    end subroutine generation_7

    !> The same for the 14th generation.
    pure subroutine generation_14(epochs, tables)
        real(dp), allocatable, intent(out) :: epochs(:)
        real(dp), allocatable, intent(out) :: tables(:, :)

        integer, parameter :: N = size(IGRF14_EPOCHS)

        epochs = [IGRF14_EPOCHS, IGRF14_END, IGRF14_LAST]
        allocate (tables(size(IGRF14_RATE), N + 2))
        tables(:, :N) = reshape(IGRF14_FIELDS, [size(IGRF14_RATE), N])
        tables(:, N + 1) = tables(:, N) + RATE_SPAN*IGRF14_RATE
        tables(:, N + 2) = tables(:, N) + (IGRF14_LAST - IGRF14_EPOCHS(N))*IGRF14_RATE
    end subroutine generation_14

    !> Coefficients at a date, linear between the epochs. Fails when the date is outside them or not
    !> a number.
    subroutine coefficients_at(decimal_year, epochs, tables, list, error)
        real(dp), intent(in) :: decimal_year    !! Year with decimals
        real(dp), intent(in) :: epochs(:)       !! Decimal years, rising
        real(dp), intent(in) :: tables(:, :)    !! One column an epoch
        real(dp), allocatable, intent(out) :: list(:)   !! At that date, nT
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: share
        integer :: i, n

        n = size(epochs)
        if (.not. (decimal_year >= epochs(1) .and. decimal_year <= epochs(n))) then
            call fail_out_of_range(error, 'date', decimal_year, epochs(1), epochs(n), 'years')
            return
        end if
        i = min(count(epochs <= decimal_year), n - 1)
        if (i == 0) then    ! a single epoch
            list = tables(:, 1)
            return
        end if
        share = (decimal_year - epochs(i))/(epochs(i + 1) - epochs(i))
        list = (1 - share)*tables(:, i) + share*tables(:, i + 1)
    end subroutine coefficients_at

    !> A field of given coefficients:
    !>
    !>     B = -grad V,  V = a sum_nm (a/r)^(n+1) P_nm(cos colat) [g cos m lon + h sin m lon]
    !>
    !> with Schmidt's semi-normalised P_nm = Pbar_nm/sqrt(2n + 1); CSR-TM-00-01 eq. (2-26) in
    !> Cartesian components. The coefficients are turned into those of the radius that gravity's have, where that is within
    !> 1 %: then both can be computed together. Fails on a degree out of range, on a list of another length, and on
    !> numbers that are not finite.
    subroutine new_igrf(name, radius, degree, list, model, error)
        character(*), intent(in) :: name    !! For output
        real(dp), intent(in) :: radius  !! a, m
        integer, intent(in) :: degree   !! Highest of the list
        real(dp), intent(in) :: list(:) !! g(1,0), g(1,1), h(1,1), g(2,0), g(2,1), h(2,1), ...; nT
        type(igrf_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: g(:, :), h(:, :)
        real(dp) :: factor, reference
        integer :: n

        if (degree < 1 .or. degree > MAX_DEGREE) then
            call fail_out_of_range(error, name//': degree', real(degree, dp), 1.0_dp, &
                                   real(MAX_DEGREE, dp))
        else if (size(list) /= degree*(degree + 2)) then
            call fail(error, name//': the number of coefficients does not agree with the degree')
        else if (.not. all(ieee_is_finite(list))) then
            call fail(error, name//': a coefficient is not a finite number')
        end if
        if (allocated(error)) return

        allocate (g(0:degree, 0:degree), h(0:degree, 0:degree), source=0.0_dp)
        reference = radius
        if (abs(radius/EARTH_RADIUS_EGM96 - 1) < 0.01_dp) reference = EARTH_RADIUS_EGM96
        do n = 1, degree
            factor = -NANOTESLA/sqrt(2*n + 1.0_dp)*(radius/reference)**(n + 1)      ! the minus of -grad
            g(n, 0) = factor*list(n**2)
            g(n, 1:n) = factor*list(n**2 + 1:n**2 + 2*n - 1:2)
            h(n, 1:n) = factor*list(n**2 + 2:n**2 + 2*n:2)
        end do
        model%name = name
        model%degree = degree
        model%potential = new_harmonic_function(reference, radius, g, h)
    end subroutine new_igrf

    pure subroutine igrf_evaluate(self, position, b)
        class(igrf_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: b(3)

        call self%potential%gradient(position, b)
    end subroutine igrf_evaluate

    !> The components of a vector along the local vertical (up), south and east, as in CSR-TM-00-01
    !> eqs. (2-26) and (2-27). On the axis of rotation, where south and east are undefined, they are
    !> those of the meridian of Greenwich: the limit for y = 0, x towards +0.
    pure subroutine spherical_components(position, b, radial, south, east)
        real(dp), intent(in) :: position(3)     !! Earth-fixed, any unit
        real(dp), intent(in) :: b(3)            !! Earth-fixed, any unit
        real(dp), intent(out) :: radial, south, east
        !! Away from the centre, south, east; unit of the vector

        real(dp) :: distance, sin_colatitude, cos_colatitude, sin_longitude, cos_longitude, outward

        distance = hypot(position(1), position(2))
        cos_longitude = 1
        sin_longitude = 0
        if (distance > 0) then
            cos_longitude = position(1)/distance
            sin_longitude = position(2)/distance
        end if
        sin_colatitude = distance/hypot(distance, position(3))
        cos_colatitude = position(3)/hypot(distance, position(3))

        outward = b(1)*cos_longitude + b(2)*sin_longitude
        radial = outward*sin_colatitude + b(3)*cos_colatitude
        south = outward*cos_colatitude - b(3)*sin_colatitude
        east = b(2)*cos_longitude - b(1)*sin_longitude
    end subroutine spherical_components
end module gracecg_environment_geomagnetic_field
