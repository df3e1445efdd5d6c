!> Whether the instruments of a satellite keep within the limits that CSR-TM-00-01 sections 3.2.1 and 3.4.1 state.
!>
!> The report's own accelerometer has scale factors beyond them (1.0101, 0.9841, 0.9881 where 1 +- 0.01 is allowed);
!> that is not repeated for every satellite that takes them.
module gracecg_simulation_instrument_limits
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_base_error, only: number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_simulation_accelerometer, only: accelerometer_t, WARNING_LENGTH
    use gracecg_simulation_magnetometer, only: magnetometer_t
    use gracecg_simulation_satellite, only: satellite_t
    implicit none
    private
    public :: instrument_warnings, full_scale_t, count_full_scale, full_scale_warnings

    !> Samples that reach the full scale of their instrument.
    type :: full_scale_t
        integer :: accelerometer = 0, accelerometer_samples = 0     !! Of so many
        integer :: magnetometer = 0, magnetometer_samples = 0       !! Of so many
    end type full_scale_t

contains

    !> One sentence for each setting beyond its limit that is not one of the report's own.
    subroutine instrument_warnings(satellite, warnings)
        type(satellite_t), intent(in) :: satellite
        type(string_t), allocatable, intent(out) :: warnings(:)

        type(accelerometer_t) :: of_report
        type(string_t), allocatable :: of_magnetometer(:)
        character(WARNING_LENGTH), allocatable :: found(:), known(:)
        integer :: i

        allocate (warnings(0))
        found = satellite%accelerometer%exceeded_limits()
        known = of_report%exceeded_limits()
        do i = 1, size(found)
            if (.not. any(known == found(i))) call append(warnings, trim(found(i)))
        end do
        call satellite%magnetometer%exceeded_limits(of_magnetometer)
        do i = 1, size(of_magnetometer)
            call append(warnings, of_magnetometer(i)%text)
        end do
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
