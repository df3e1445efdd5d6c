!> The geomagnetic field: identities, independently computed values, and the reader of SHC files.
module test_geomagnetic_field
    use vocabulary
    use gracecg_base_constants, only: EARTH_RADIUS_IGRF, NANOTESLA
    use gracecg_environment_geomagnetic_field
    use gracecg_environment_magnetic_storm, only: storm_field_deviation
    use gracecg_environment_shc_file, only: read_shc
    implicit none
    private
    public :: collect_geomagnetic_field

    character(*), parameter :: FIXTURES = 'test/fixtures/shc/'

    !> Earth-fixed places, m
    real(dp), parameter :: PLACES(3, 5) = reshape([ &
        4512000.0_dp, -2708000.0_dp, -4398000.0_dp, &
        -1020000.0_dp, 150000.0_dp, 6650000.0_dp, &
        0.0_dp, 0.0_dp, 6850000.0_dp, &
        0.0_dp, 0.0_dp, -6790000.0_dp, &
        -3e7_dp, 2e7_dp, 1e6_dp], [3, 5])

contains

    !> (6.1): 42 nT at Kp = 2.5 (the report's place of use; it states 150 nT after adding other effects), e times as
    !> much for 1.75 more, and the 4 nT of its factor at Kp = -1.6.
    subroutine test_storm(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, storm_field_deviation(2.5_dp)*1e9_dp, 41.64_dp, thr=0.01_dp)
        call check(error, storm_field_deviation(4.25_dp)/storm_field_deviation(2.5_dp), exp(1.0_dp), thr=1e-14_dp)
        call check(error, storm_field_deviation(-1.6_dp), 4e-9_dp, thr=1e-24_dp)
    end subroutine test_storm

    subroutine collect_geomagnetic_field(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('values-from-the-definition', test_definition), &
                    new_unittest('values-of-ppigrf', test_ppigrf), &
                    new_unittest('poles-are-ordinary-places', test_poles), &
                    new_unittest('linear-between-epochs', test_linear), &
                    new_unittest('generations', test_generations), &
                    new_unittest('spherical-components', test_spherical_components), &
                    new_unittest('bad-arguments-are-refused', test_bad_arguments), &
                    new_unittest('extrapolated-after-2030', test_extrapolated), &
                    new_unittest('shc-file', test_shc_file), &
                    new_unittest('corrupted-shc-files', test_corrupted_files), &
                    new_unittest('storm-by-kp', test_storm)]
    end subroutine collect_geomagnetic_field

    !> Values of tools/reference_harmonics.py: from the definition (2-26), with 60 digits; in nT.
    subroutine test_definition(error)
        type(error_type), allocatable, intent(out) :: error
        type(igrf_t) :: model

        call make('igrf95', 1987.3_dp, model)
        call check_field(model, PLACES(:, 1), [15874.293797256640155_dp, &
                                               -14366.015382438673426_dp, &
                                               -1111.2697229619505931_dp], error)
        call check_field(model, PLACES(:, 2), [10689.65076516920118_dp, &
                                               -2523.6735582652788004_dp, &
                                               -47898.210990332552783_dp], error)
        call check_field(model, PLACES(:, 3), [-1102.5572253556066774_dp, &
                                               -1285.7164322582202167_dp, &
                                               -46184.519855962979039_dp], error)
        call make('igrf95', 1998.6_dp, model)
        call check_field(model, PLACES(:, 1), [15605.674356561878695_dp, &
                                               -13912.33336456215164_dp, &
                                               -1656.3857963592740421_dp], error)
        call check_field(model, PLACES(:, 3), [-1115.4567763612002154_dp, &
                                               -1077.999150358964457_dp, &
                                               -45979.024995886444383_dp], error)
    end subroutine test_definition

    subroutine check_field(model, place, expected, error)
        type(igrf_t), intent(in) :: model
        real(dp), intent(in) :: place(3), expected(3)   !! m; nT
        type(error_type), allocatable, intent(inout) :: error
        real(dp) :: b(3)

        call model%evaluate(place, b)
        call check(error, norm2(b/NANOTESLA - expected), 0.0_dp, thr=1e-9_dp)
    end subroutine check_field

    !> Values of the Python package ppigrf 2.1.0 (igrf_gc: geocentric radial, south, east), nT.
    subroutine test_ppigrf(error)
        type(error_type), allocatable, intent(out) :: error

        call compare(1905.0_dp, 6371.2_dp, 60.0_dp, 20.0_dp, &
                     [-26479.29328550498_dp, -29017.72329869505_dp, -3476.829978982031_dp], error)
        call compare(2020.0_dp, 6860.25_dp, 37.0_dp, -72.5_dp, &
                     [-42695.7090093448_dp, -11176.12552051683_dp, -3093.4288897855918_dp], error)
        call compare(2022.5_dp, 6790.0_dp, 118.0_dp, 141.0_dp, &
                     [38889.95062326877_dp, -22372.92425492287_dp, 2850.0069171551136_dp], error)

    contains

        subroutine compare(year, radius, colatitude, longitude, expected, error)
            real(dp), intent(in) :: year, radius, colatitude, longitude     !! km, deg
            real(dp), intent(in) :: expected(3)                             !! nT
            type(error_type), allocatable, intent(inout) :: error
            type(igrf_t) :: model
            real(dp) :: place(3), b(3), found(3)

            call make('igrf14', year, model)
            place = 1000*radius*[sin(colatitude*DEGREE)*cos(longitude*DEGREE), &
                                 sin(colatitude*DEGREE)*sin(longitude*DEGREE), &
                                 cos(colatitude*DEGREE)]
            call model%evaluate(place, b)
            call spherical_components(place, b, found(1), found(2), found(3))
            call check(error, norm2(found/NANOTESLA - expected), 0.0_dp, thr=1e-8_dp)
        end subroutine compare
    end subroutine test_ppigrf

    !> The field changes by less than 0.03 nT/m, so hardly over a centimetre across the axis.
    subroutine test_poles(error)
        type(error_type), allocatable, intent(out) :: error
        type(igrf_t) :: model
        real(dp) :: at_pole(3), near(3)
        integer :: i, pole

        call make('igrf95', 1989.0_dp, model)
        do pole = 3, 4
            call model%evaluate(PLACES(:, pole), at_pole)
            do i = 0, 11
                call model%evaluate(PLACES(:, pole) + &
                                    1e-2_dp*[cos(30*i*DEGREE), sin(30*i*DEGREE), 0.0_dp], near)
                call check(error, norm2(near - at_pole), 0.0_dp, thr=3e-4_dp*NANOTESLA)
            end do
        end do
    end subroutine test_poles

    subroutine test_linear(error)
        type(error_type), allocatable, intent(out) :: error

        call compare('igrf95', 1985.0_dp, 1990.0_dp, 0.2_dp, error)
        call compare('igrf95', 1990.0_dp, 1995.0_dp, 0.7_dp, error)
        call compare('igrf95', 1995.0_dp, 2000.0_dp, 0.5_dp, error)
        call compare('igrf14', 1900.0_dp, 1905.0_dp, 0.9_dp, error)
        call compare('igrf14', 1995.0_dp, 2000.0_dp, 0.4_dp, error)
        call compare('igrf14', 2025.0_dp, 2030.0_dp, 0.6_dp, error)

    contains

        subroutine compare(generation, first, last, share, error)
            character(*), intent(in) :: generation
            real(dp), intent(in) :: first, last, share
            type(error_type), allocatable, intent(inout) :: error
            type(igrf_t) :: model(3)
            real(dp) :: b(3, 3)
            integer :: i

            call make(generation, first, model(1))
            call make(generation, last, model(2))
            call make(generation, first + share*(last - first), model(3))
            do i = 1, 3
                call model(i)%evaluate(PLACES(:, 1), b(:, i))
            end do
            call check(error, norm2(b(:, 1) - b(:, 2)) > 10*NANOTESLA, 'the field does not change')
            call check(error, norm2((1 - share)*b(:, 1) + share*b(:, 2) - b(:, 3)), 0.0_dp, &
                       thr=1e-9_dp*NANOTESLA)
        end subroutine compare
    end subroutine test_linear

    !> Definitive models stay what they are; 1995.0 was replaced (h33 by 21 nT), 2000.0 foreseen.
    subroutine test_generations(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, difference(1985.0_dp), 0.0_dp, thr=1e-9_dp)
        call check(error, difference(1989.0_dp), 0.0_dp, thr=1e-9_dp)
        call check(error, difference(1990.0_dp), 0.0_dp, thr=1e-9_dp)
        call check(error, difference(1995.0_dp) > 1 .and. difference(1995.0_dp) < 100, '1995')
        call check(error, difference(2000.0_dp) > 10 .and. difference(2000.0_dp) < 300, '2000')

    contains

        !> nT
        real(dp) function difference(year)
            real(dp), intent(in) :: year
            type(igrf_t) :: old, new
            real(dp) :: b_old(3), b_new(3)

            call make('igrf95', year, old)
            call make('igrf14', year, new)
            call old%evaluate(PLACES(:, 1), b_old)
            call new%evaluate(PLACES(:, 1), b_new)
            difference = norm2(b_old - b_new)/NANOTESLA
        end function difference
    end subroutine test_generations

    !> Back by the matrix of CSR-TM-00-01 eq. (2-27), and the convention on the axis.
    subroutine test_spherical_components(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: B(3) = [1.0_dp, 2.0_dp, -3.0_dp]
        real(dp) :: radial, south, east, latitude, longitude
        real(dp) :: up(3), southward(3), eastward(3), found(3)

        latitude = -35*DEGREE
        longitude = 130*DEGREE
        up = [cos(latitude)*cos(longitude), cos(latitude)*sin(longitude), sin(latitude)]
        southward = [sin(latitude)*cos(longitude), sin(latitude)*sin(longitude), -cos(latitude)]
        eastward = [-sin(longitude), cos(longitude), 0.0_dp]
        call spherical_components(7e6_dp*up, B, radial, south, east)
        call check(error, norm2(radial*up + south*southward + east*eastward - B), 0.0_dp, &
                   thr=2e-15_dp)
        call spherical_components([0.0_dp, 0.0_dp, 7e6_dp], B, found(1), found(2), found(3))
        call check(error, all(abs(found - [B(3), B(1), B(2)]) <= 0), 'north pole')
        call spherical_components([0.0_dp, 0.0_dp, -7e6_dp], B, found(1), found(2), found(3))
        call check(error, all(abs(found - [-B(3), -B(1), B(2)]) <= 0), 'south pole')
        call spherical_components([1e-3_dp, 0.0_dp, -7e6_dp], B, radial, south, east)
        call check(error, norm2(found - [radial, south, east]), 0.0_dp, thr=1e-9_dp)
    end subroutine test_spherical_components

    subroutine test_bad_arguments(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: LIST(3) = [1.0_dp, 2.0_dp, 3.0_dp]
        type(igrf_t) :: model
        type(error_t), allocatable :: failure

        call refuse_date('igrf95', 1984.99_dp, 'igrf95: date = 1984.99 years is outside', error)
        call refuse_date('igrf95', 2000.01_dp, 'range 1985 to 2000 years', error)
        call refuse_date('igrf14', 1899.9_dp, 'range 1900 to 2040 years', error)
        call refuse_date('igrf14', 2040.1_dp, 'range 1900 to 2040 years', error)
        call refuse_date('igrf14', nan, 'is outside', error)
        call check(error, is_extrapolated('igrf14', 2030.1_dp) .and. .not. is_extrapolated('igrf14', 2030.0_dp))
        call refuse_date('igrf59', 1990.0_dp, 'did you mean "igrf95"', error)
        call new_igrf('x', EARTH_RADIUS_IGRF, 0, LIST, model, failure)
        call check_fails(error, failure, 'x: degree = 0')
        call new_igrf('x', EARTH_RADIUS_IGRF, 2, LIST, model, failure)
        call check_fails(error, failure, 'does not agree with the degree')
        call new_igrf('x', EARTH_RADIUS_IGRF, 1, nan*LIST, model, failure)
        call check_fails(error, failure, 'not a finite number')
    end subroutine test_bad_arguments

    !> After 2030 the field goes on as it went before.
    subroutine test_extrapolated(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: PLACE(3) = [4e6_dp, 3e6_dp, 5e6_dp]
        type(igrf_t) :: model
        type(error_t), allocatable :: failure
        real(dp) :: b(3, 3)
        integer :: i

        do i = 1, 3
            call igrf('igrf14', 2028.0_dp + 2*i, model, failure)
            if (failed(error, failure)) return
            call model%evaluate(PLACE, b(:, i))
        end do
        call check(error, norm2(b(:, 3) - 2*b(:, 2) + b(:, 1)) < 1e-18_dp)
        call check(error, norm2(b(:, 2) - b(:, 1)) > 1e-9_dp)
    end subroutine test_extrapolated

    subroutine refuse_date(generation, year, part, error)
        character(*), intent(in) :: generation, part
        real(dp), intent(in) :: year
        type(error_type), allocatable, intent(inout) :: error
        type(igrf_t) :: model
        type(error_t), allocatable :: failure

        call igrf(generation, year, model, failure)
        call check_fails(error, failure, part)
    end subroutine refuse_date

    !> A file with the IGRF-14 of 2015, 2020 and 2025 to degree 2, against the same figures by hand.
    subroutine test_shc_file(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: FIELD_2015(8) = [ &
            -29441.46_dp, -1501.77_dp, 4795.99_dp, -2445.88_dp, &
            3012.20_dp, -2845.41_dp, 1676.35_dp, -642.17_dp]
        real(dp), parameter :: FIELD_2020(8) = [ &
            -29403.41_dp, -1451.37_dp, 4653.35_dp, -2499.78_dp, &
            2981.96_dp, -2991.72_dp, 1676.85_dp, -734.62_dp]
        type(igrf_t) :: from_file, by_hand
        type(error_t), allocatable :: failure
        real(dp) :: expected(3)

        call read_shc(FIXTURES//'valid.shc', 2016.0_dp, from_file, failure)
        if (failed(error, failure)) return
        call new_igrf('by hand', EARTH_RADIUS_IGRF, 2, 0.8_dp*FIELD_2015 + 0.2_dp*FIELD_2020, &
                      by_hand, failure)
        if (failed(error, failure)) return
        call by_hand%evaluate(PLACES(:, 2), expected)
        call check_field(from_file, PLACES(:, 2), expected/NANOTESLA, error)
    end subroutine test_shc_file

    subroutine test_corrupted_files(error)
        type(error_type), allocatable, intent(out) :: error

        call refuse('no-such-file', 'no-such-file.shc', error)
        call refuse('corrupted-empty', 'empty.shc: holds no data', error)
        call refuse('corrupted-head', '.shc:3: number of epochs: "3.5" is not an integer', error)
        call refuse('corrupted-head-number', '.shc:3: column 7: "T" is not a finite number', error)
        call refuse('corrupted-lowest-degree', '.shc:3: the lowest degree must be 1', error)
        call refuse('corrupted-highest-degree', '.shc:3: the highest degree must not', error)
        call refuse('corrupted-splines', '.shc:3: splines of order 6', error)
        call refuse('corrupted-epoch-count', '.shc:4: has 2 columns, expected 3: epochs', error)
        call refuse('corrupted-epoch-order', '.shc:4: the epochs must rise', error)
        call refuse('corrupted-nan', '.shc:8: value: "NaN" is not a finite number', error)
        call refuse('corrupted-order', '.shc:8: order: ', error)
        call refuse('corrupted-duplicate', '.shc:9: this degree and order was given', error)
        call refuse('corrupted-missing', 'there is no coefficient h(2,1)', error)
        call refuse('corrupted-truncated', '.shc:12: has 4 columns, expected 5: degree, order', error)
        call refuse('valid', 'date = 2014 years is outside the allowed range 2015 to 2025', error, &
                    2014.0_dp)
    end subroutine test_corrupted_files

    !> Checks that a file is refused with a message that holds `part`; does nothing after a failure.
    subroutine refuse(name, part, error, year)
        character(*), intent(in) :: name, part
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in), optional :: year
        type(igrf_t) :: model
        type(error_t), allocatable :: failure
        real(dp) :: date

        date = 2020
        if (present(year)) date = year
        call read_shc(FIXTURES//name//'.shc', date, model, failure)
        call check_fails(error, failure, part)
    end subroutine refuse

    subroutine make(generation, year, model)
        character(*), intent(in) :: generation
        real(dp), intent(in) :: year
        type(igrf_t), intent(out) :: model
        type(error_t), allocatable :: failure

        call igrf(generation, year, model, failure)
        call need(failure)
    end subroutine make
end module test_geomagnetic_field
