!> Whether the instruments of a satellite keep within the limits that CSR-TM-00-01 sections 3.2.1 and 3.4.1 state.
!>
!> The report's own accelerometer has scale factors beyond them (1.0101, 0.9841, 0.9881 where 1 +- 0.01 is allowed);
!> that is not repeated for every satellite that takes them.
module gracecg_simulation_instrument_limits
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, NANOTESLA
    use gracecg_base_error, only: number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_simulation_accelerometer, only: accelerometer_t
    use gracecg_simulation_satellite, only: satellite_t
    implicit none
    private
    public :: instrument_warnings, full_scale_t, count_full_scale, full_scale_warnings

    real(dp), parameter :: ROUNDING = 1e-12_dp      ! of numbers taken to the units of their limits

    !> Samples that reach the full scale of their instrument.
    type :: full_scale_t
        integer :: accelerometer = 0, accelerometer_samples = 0     !! Of so many
        integer :: magnetometer = 0, magnetometer_samples = 0       !! Of so many
    end type full_scale_t

contains

    !> One sentence for each setting beyond its limit (NaN is) that is not one of the report's own.
    subroutine instrument_warnings(satellite, warnings)
        type(satellite_t), intent(in) :: satellite
        type(string_t), allocatable, intent(out) :: warnings(:)

        type(accelerometer_t) :: printed

        allocate (warnings(0))
        associate (a => satellite%accelerometer, m => satellite%magnetometer)
            ! those of scale2, scale3 and bias as corrected in their exponents
            call compare('accelerometer scale1 - 1', a%scale1 - 1, [0.01_dp, 0.01_dp, 0.01_dp], '', printed%scale1 - 1)
            call compare('accelerometer scale2', a%scale2, [20.0_dp, 50.0_dp, 20.0_dp], ' s^2/m', printed%scale2)
            call compare('accelerometer scale3', a%scale3, [3e4_dp, 3e5_dp, 3e4_dp], ' s^4/m^2', printed%scale3)
            call compare('accelerometer bias', a%bias, [2e-6_dp, 5e-5_dp, 2e-6_dp], ' m/s^2', printed%bias)
            if (a%limited) call compare('accelerometer full scale', [a%range], [printed%range], ' m/s^2')
            if (a%quantised) call compare('accelerometer resolution', [a%resolution], [printed%resolution], ' m/s^2')
            call compare('magnetometer bias', m%bias/NANOTESLA, spread(100.0_dp, 1, 3), ' nT')
            call compare('magnetometer linearity error', [m%linearity]/NANOTESLA, [25.0_dp], ' nT')
            call compare('magnetometer noise', [m%noise]/NANOTESLA, [3.0_dp], ' nT')
            if (m%limited) call compare('magnetometer full scale', [m%range]/NANOTESLA, [50e3_dp], ' nT')
            if (m%quantised) call compare('magnetometer resolution', [m%resolution]/NANOTESLA, [25.0_dp], ' nT')
        end associate

    contains

        !> One number, or one by axis.
        subroutine compare(name, values, limits, unit, known)
            character(*), intent(in) :: name, unit
            real(dp), intent(in) :: values(:), limits(:)
            real(dp), intent(in), optional :: known(:)      !! The report's own

            character(:), allocatable :: axis
            integer :: i

            do i = 1, size(values)
                if (abs(values(i)) <= limits(i)*(1 + ROUNDING)) cycle
                if (present(known)) then
                    if (abs(values(i) - known(i)) <= 0) cycle
                end if
                axis = ''
                if (size(values) > 1) axis = ', '//AXES(i)//' axis'
                call append(warnings, name//axis//': '//number_text(values(i))//unit//' exceeds the limit '// &
                            number_text(limits(i))//unit)
            end do
        end subroutine compare
    end subroutine instrument_warnings

    !> Counts the samples of a set that reach the full scale of their instrument, with those counted before.
    pure subroutine count_full_scale(satellite, observations, found)
        type(satellite_t), intent(in) :: satellite
        type(observation_set_t), intent(in) :: observations     !! Of this satellite
        type(full_scale_t), intent(inout) :: found

        found%accelerometer = found%accelerometer + &
                              count(maxval(abs(observations%acceleration), 1) >= satellite%accelerometer%range)
        found%accelerometer_samples = found%accelerometer_samples + size(observations%acceleration, 2)
        found%magnetometer = found%magnetometer + count(maxval(abs(observations%field), 1) >= satellite%magnetometer%range)
        found%magnetometer_samples = found%magnetometer_samples + size(observations%field, 2)
    end subroutine count_full_scale

    !> A sentence for each instrument whose samples reach its full scale: cut off there where the instrument is
    !> `limited`, else beyond what it can measure.
    subroutine full_scale_warnings(satellite, found, warnings)
        type(satellite_t), intent(in) :: satellite
        type(full_scale_t), intent(in) :: found         !! Of its samples
        type(string_t), allocatable, intent(out) :: warnings(:)

        allocate (warnings(0))
        associate (a => satellite%accelerometer, m => satellite%magnetometer)
            call say('accelerometer', found%accelerometer, found%accelerometer_samples, a%limited, &
                     number_text(a%range)//' m/s^2')
            call say('magnetometer', found%magnetometer, found%magnetometer_samples, m%limited, &
                     number_text(m%range/NANOTESLA)//' nT')
        end associate

    contains

        subroutine say(name, n, samples, limited, range_text)
            character(*), intent(in) :: name, range_text
            integer, intent(in) :: n, samples
            logical, intent(in) :: limited

            character(:), allocatable :: what

            if (n == 0) return
            what = ' lie beyond its full scale of '//range_text//', which `limited` would cut off'
            if (limited) what = ' are cut off at its full scale of '//range_text
            call append(warnings, name//': '//integer_text(n)//' of '//integer_text(samples)//' samples'//what)
        end subroutine say
    end subroutine full_scale_warnings
end module gracecg_simulation_instrument_limits
