!> The commands of `model`: their numbers, and places where no model holds.
module test_model_commands
    use vocabulary
    use gracecg_base_constants, only: ASTRONOMICAL_UNIT
    use gracecg_base_text, only: split, parse_real
    use gracecg_files_file, only: text_file_t, text_file_of
    use command_fixture
    implicit none
    private
    public :: collect_model_commands

    character(*), parameter :: EQUATOR = ' --position 6837865 0 0'

contains

    subroutine collect_model_commands(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('gravity', test_gravity), &
                    new_unittest('field', test_field), &
                    new_unittest('density', test_density), &
                    new_unittest('wind', test_wind_model), &
                    new_unittest('sun', test_sun_model), &
                    new_unittest('impossible-places', test_impossible)]
    end subroutine collect_model_commands

    !> The header and the numbers of the row that a line prints.
    subroutine row_of(error, line, header, values)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: line, header
        real(dp), intent(out) :: values(:)
        type(text_file_t) :: text
        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: output
        integer :: i
        logical :: ok

        values = 0
        call succeeds(error, line, output)
        if (allocated(error)) return
        text = text_file_of(output, 'output')
        if (unmet(error, text%line(text%line_count() - 1), header, line)) return
        fields = split(text%line(text%line_count()), ',')
        if (unmet(error, size(fields), size(values), line)) return
        do i = 1, size(values)
            call parse_real(fields(i)%text, values(i), ok)
            call check(error, ok, fields(i)%text)
        end do
    end subroutine row_of

    !> Degree 0 is the point mass; the whole model differs from it by the oblateness, some 1e-3.
    subroutine test_gravity(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEADER = 'ax_m_s2,ay_m_s2,az_m_s2,potential_m2_s2'
        real(dp) :: point(4), full(4)
        real(dp), parameter :: R = 6837865.0_dp

        call row_of(error, 'model gravity --degree 0'//EQUATOR, HEADER, point)
        call row_of(error, 'model gravity'//EQUATOR, HEADER, full)
        call check(error, abs(point(1) + EARTH_GM/R**2) < 1e-14_dp*10 .and. &
                   abs(point(2)) <= 0 .and. abs(point(4) - EARTH_GM/R) < 1e-8_dp*10)
        call check(error, full(1)/point(1) > 1.0013_dp .and. full(1)/point(1) < 1.0015_dp)
        call refused(error, 'model gravity --degree 71'//EQUATOR, STATUS_FAILED, '70')
        call refused(error, 'model gravity --degree 5 --order 6'//EQUATOR, STATUS_FAILED, 'order')
        call refused(error, 'model gravity --file nowhere.gfc'//EQUATOR, STATUS_FAILED, 'nowhere.gfc: no such file')
    end subroutine test_gravity

    !> On the equator at Greenwich radial is x, south -z, east y. The two tables agree in 1989.
    subroutine test_field(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEADER = &
            'bx_tesla,by_tesla,bz_tesla,b_radial_tesla,b_south_tesla,b_east_tesla'
        character(*), parameter :: IN_1989 = 'model field --date 1989-01-02T00:00:00'
        character(:), allocatable :: output, messages
        real(dp) :: old(6), new(6)
        integer :: status

        call row_of(error, IN_1989//EQUATOR, HEADER, old)
        call row_of(error, IN_1989//' --table igrf14'//EQUATOR, HEADER, new)
        call check(error, maxval(abs(old(4:6) - [old(1), -old(3), old(2)])) <= 0)
        call check(error, maxval(abs(old - new)) < 1e-12_dp .and. norm2(old(:3)) > 2e-5_dp)
        call refused(error, 'model field --date 2005-06-01'//EQUATOR, STATUS_FAILED, &
                     'igrf95 ... 1985 to 2000 ... igrf14 covers 1900 to 2030')
        call run('model field --date 2031-06-01 --table igrf14'//EQUATOR, status, output, messages)
        call check(error, status == STATUS_DONE .and. index(messages, 'is extrapolated: igrf14 ends') > 0, messages)
    end subroutine test_field

    !> The density is the sum over the constituents (with O2, a little more); the row of the table
    !> is that of the indices given.
    subroutine test_density(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEADER = &
            'density_kg_m3,temperature_kelvin,exospheric_temperature_kelvin,n_he_per_m3,n_o_per_m3,n_n2_per_m3,'// &
            'height_km,latitude_deg,local_time_h,day,f107_sfu,f107a_sfu,kp'
        character(*), parameter :: AT = 'model density --date 1989-01-02T06:00:00'//EQUATOR
        real(dp), parameter :: ATOMIC_MASS_UNIT = 1.66054e-27_dp
        real(dp) :: air(13), same(13), sum_of_parts

        call row_of(error, AT, HEADER, air)
        call row_of(error, AT//' --f107 185.7 --f107a 210.6 --kp 2.7', HEADER, same)
        if (allocated(error)) return
        sum_of_parts = ATOMIC_MASS_UNIT*(4*air(4) + 16*air(5) + 28*air(6))
        call check(error, sum_of_parts/air(1) < 1.001_dp .and. sum_of_parts/air(1) > 0.98_dp)
        call check(error, air(1) > 1e-12_dp .and. air(1) < 1e-11_dp .and. air(2) < air(3))
        call check(error, all(abs(air(7:10) - [459.728_dp, 0.0_dp, 6.0_dp, 1.25_dp]) < 1e-9_dp))
        call refused(error, 'model density --date 1995-06-01'//EQUATOR, STATUS_FAILED, &
                     '--f107, --f107a and --kp ... 1988-12-01 to 1989-02-28')
        call refused(error, AT//' --f107 10 --f107a 210 --kp 2', STATUS_FAILED, '10 ... 50')
        call refused(error, 'model density --date 1989-01-02 --position 6.4e6 0 0', STATUS_FAILED, &
                     'height 21.863 km ... valid from 120 km')
    end subroutine test_density

    subroutine test_wind_model(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: WIND_HEADER = 'east_m_s,north_m_s,height_km,latitude_deg,local_time_h'
        real(dp) :: wind(5), later(5)
        character(:), allocatable :: output

        call row_of(error, 'model wind --date 1989-01-02'//EQUATOR, WIND_HEADER, wind)
        ! a day later at the same place it is the same local time
        call row_of(error, 'model wind --date 1989-01-03'//EQUATOR, WIND_HEADER, later)
        call check(error, maxval(abs(wind - later)) <= 0 .and. norm2(wind(:2)) > 10 .and. norm2(wind(:2)) < 500)
        call prints(error, 'model wind --date 1989-01-02 --format json'//EQUATOR, '"note": "HWM93 of 1989-01-02')
    end subroutine test_wind_model

    !> On 2 January 1989: right ascension 281.9 deg, declination -23 deg, near the perihelion.
    subroutine test_sun_model(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: sun(4)
        real(dp), parameter :: DEGREE = acos(-1.0_dp)/180

        call row_of(error, 'model sun --date 1989-01-02T00:00:00', 'x_m,y_m,z_m,distance_au', sun)
        call check(error, abs(norm2(sun(:3))/ASTRONOMICAL_UNIT - sun(4)) < 1e-14_dp*10)
        call check(error, abs(sun(4) - 0.9833_dp) < 1e-4_dp)
        call check(error, abs(atan2(sun(2), sun(1))/DEGREE + 360 - 282.75_dp) < 1 .and. &
                   abs(asin(sun(3)/norm2(sun(:3)))/DEGREE + 23) < 0.5_dp)
    end subroutine test_sun_model

    subroutine test_impossible(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: MODELS(4) = [character(27) :: 'gravity', &
                                                'field --date 1989-01-02', &
                                                'density --date 1989-01-02', &
                                                'wind --date 1989-01-02']
        integer :: i

        do i = 1, size(MODELS)
            call refused(error, 'model '//trim(MODELS(i))//' --position 0 0 0', STATUS_FAILED, &
                         '--position ... inside the Earth')
            call refused(error, 'model '//trim(MODELS(i))//' --position 6370e3 0 0', STATUS_FAILED, &
                         '--position ... 8.137 km below the ellipsoid')
            call refused(error, 'model '//trim(MODELS(i))//' --position 6837.865 0 0', STATUS_FAILED, 'give Earth-fixed metres')
        end do
    end subroutine test_impossible
end module test_model_commands
