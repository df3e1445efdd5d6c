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
    public :: instrument_warnings, full_scale_warnings

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

    !> A sentence for each instrument whose samples reach its full scale: cut off there where the instrument is
    !> `limited`, else beyond what it can measure.
    subroutine full_scale_warnings(satellite, observations, warnings)
        type(satellite_t), intent(in) :: satellite
        type(observation_set_t), intent(in) :: observations     !! Of this satellite
        type(string_t), allocatable, intent(out) :: warnings(:)

        allocate (warnings(0))
        associate (a => satellite%accelerometer, m => satellite%magnetometer)
            call compare('accelerometer', observations%acceleration, a%range, a%limited, number_text(a%range)//' m/s^2')
            call compare('magnetometer', observations%field, m%range, m%limited, number_text(m%range/NANOTESLA)//' nT')
        end associate

    contains

        subroutine compare(name, samples, range, limited, range_text)
            character(*), intent(in) :: name, range_text
            real(dp), intent(in) :: samples(:, :), range
            logical, intent(in) :: limited

            character(:), allocatable :: what
            integer :: n

            n = count(maxval(abs(samples), 1) >= range)
            if (n == 0) return
            what = ' lie beyond its full scale of '//range_text//', which `limited` would cut off'
            if (limited) what = ' are cut off at its full scale of '//range_text
            call append(warnings, name//': '//integer_text(n)//' of '//integer_text(size(samples, 2))//' samples'//what)
        end subroutine compare
    end subroutine full_scale_warnings
end module gracecg_simulation_instrument_limits
